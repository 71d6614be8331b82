"""What the documentation shows is what its data give: nothing is pasted."""

import re
from io import BytesIO

import matplotlib.image
import numpy as np
import pandas as pd
import pytest

from t2l.figures.kept import DPI, FIGURES
from t2l.gains import Cell, Grid
from t2l.names import heading, with_minus
from t2l.plotting.style import write
from t2l.report.kept import pages, registered, with_counts
from t2l.stats.collections import by_collection, over_collections
from t2l.stats.rank import spearman
from t2l.stats.rank_tests import rank_correlation
from t2l.stats.regions import region_table
from t2l.study.attenuation.claims import stronger, with_errors
from t2l.study.cloning.claims import ANEW_TASKS, LOSS
from t2l.study.kept.evidence import evidence
from t2l.study.kept.tables import COMPARED, collections, tables
from t2l.study.published.numbers import grid_of
from t2l.study.scoreboard.table import counts, scoreboard
from tests.conftest import ROOT

DATA = ROOT / "docs/data"
RULE = registered(ROOT / "config/studies/transfer_decision.yaml")
# what is rendered is not kept
NOT_DRAWN = re.compile(r".*_frames|diagnosis_report")
# rows of the page on cloning: its words, the file, the variant
ROWS = {
    "10 Hz": ("ablations", "rate_10_hz"),
    "joint deltas": ("ablations", "joint_deltas"),
    "task-space control (gains of the tool)": ("ablations", "task_space"),
    "single actions, no chunks": ("ablations", "chunk_1"),
    "no gravity compensation": ("ablations", "no_gravity_compensation"),
    "50 demonstrations": ("ablations", "demonstrations_50"),
    "25 demonstrations": ("ablations", "demonstrations_25"),
    "regression": ("policy_classes", "regression"),
    "diffusion": ("policy_classes", "diffusion"),
    "Transformer": ("policy_classes", "transformer"),
    "Transformer, 50 epochs": ("policy_classes", "transformer_50_epochs"),
    "lerobot's ACT": ("lerobot_policies", "lerobot_act"),
    "lerobot's Diffusion Policy": ("lerobot_policies", "lerobot_diffusion"),
    "nominal": ("cloning_grid", "nominal"),
    "no noise on observations": ("cloning_grid", "observation_noise_0"),
    "25": ("demonstrations", "demonstrations_25"),
    "50": ("demonstrations", "demonstrations_50"),
    "100": ("demonstrations", "demonstrations_100"),
    "200": ("demonstrations", "demonstrations_200"),
    "400": ("demonstrations", "demonstrations_400"),
    "900": ("demonstrations", "demonstrations_900"),
}


@pytest.fixture(scope="module")
def board():
    return scoreboard(evidence(DATA, RULE))


@pytest.fixture(scope="module")
def made():
    """Each table by its name: numbers, and as text."""
    return {name: (table, text) for name, table, text in tables(DATA, RULE)}


def test_the_pages_tell_the_scoreboard_that_the_data_give(board):
    for name, text in pages(ROOT, board):
        assert text == (ROOT / name).read_text(), f"{name}: python -m t2l.report.kept"


def test_a_page_that_tells_other_counts_is_corrected(board):
    found = counts(board)
    stale = (
        "of 9 statements 1 are reproduced, 2 are\nnot, 3 cannot be told, and 4 are [open](#open)."
    )
    told = [len(board), *(found[v] for v in ("reproduced", "not reproduced", "cannot be told"))]
    text = with_counts(stale, board)
    assert [int(number) for number in re.findall(r"\d+", text)] == [*told, found["not run"]]
    assert re.sub(r"\d+", "0", text) == re.sub(r"\d+", "0", stale)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_that_of_the_data(name, tmp_path):
    drawn = tmp_path / f"{name}.png"
    write(FIGURES[name](DATA), [drawn], dpi=DPI.get(name, DPI[""]))
    ours, shown = (
        matplotlib.image.imread(BytesIO(path.read_bytes()))
        for path in (drawn, ROOT / f"docs/{name}.png")
    )
    assert ours.shape == shown.shape
    # another version of a font shifts edges, another number changes whole squares
    assert np.abs(ours - shown).mean() < 2e-3


def test_every_figure_is_drawn_from_data_or_said_not_to_be():
    shown = {path.stem for path in (ROOT / "docs").glob("*.png")}
    assert set(FIGURES) <= shown
    assert all(NOT_DRAWN.fullmatch(name) for name in shown - set(FIGURES))


@pytest.mark.parametrize("words", ROWS)
def test_a_row_of_the_page_on_cloning_is_that_of_the_data(words):
    file, variant = ROWS[words]
    policies = pd.read_csv(DATA / f"{file}.csv").query("variant == @variant")
    grid = Grid(tuple(sorted(policies.kp.unique())), tuple(sorted(policies.kd.unique())), 128, 16)
    row = region_table({variant: policies}, grid).iloc[0]
    text = (ROOT / "docs/results_cloning.md").read_text()
    (shown,) = re.findall(rf"^\| {re.escape(words)} \|(.*)\|$", text, flags=re.M)
    told = [cell.strip(" *") for cell in shown.split("|")]
    shares = [f"{100 * row[f'success_{region}']:.1f} %" for region in ("co", "so", "cu", "su")]
    assert [re.sub(r" \(.*", "", cell) for cell in told[:4]] == shares
    for cell, p in zip(told[4:], (row.p_co_rest, row.p_co_so), strict=True):
        assert cell == ("< 0.001" if p < 0.001 else f"{p:.3f}")


@pytest.mark.parametrize("words", list(COMPARED)[:6])
def test_a_task_of_the_page_on_cloning_is_that_of_the_data(words):
    file, variant = COMPARED[words]
    policies = pd.read_csv(DATA / f"{file}.csv").query("variant == @variant")
    grid = grid_of(policies, "cloning")
    row = region_table({variant: policies}, grid).iloc[0]
    gains = zip(policies.kp, policies.kd, strict=True)
    others = policies[[grid.region(Cell(*both)) != "CO" for both in gains]]
    shares = [row.success_co, row.success_so, others.success.mean()]
    p = min(1.0, 6 * row.p_co_rest)  # for six tasks, as the study corrects
    told = [*(f"{100 * share:.1f} %" for share in shares), "< 0.001" if p < 0.001 else f"{p:.3f}"]
    text = (ROOT / "docs/results_cloning.md").read_text()
    (shown,) = re.findall(rf"^\| \[?{words}[^|]*`[a-z_]+` \|(.*)\|$", text, flags=re.M)
    cells = [cell.strip() for cell in shown.split("|")]
    assert cells[:4] == told
    assert [re.match(r"[+−].\.\d\d", cell)[0] for cell in cells[4:6]] == [
        with_minus(f"{beta:+.2f}") for beta in (row.beta_kp, row.beta_kd)
    ]


def test_what_the_page_on_cloning_says_of_an_operator_is_in_the_data():
    policies = pd.read_csv(DATA / "end_to_end.csv")
    text = (ROOT / "docs/results_cloning.md").read_text()
    corners = [(32, 128), (2048, 128), (32, 2), (2048, 2)]
    for variant, words in (("operator", "an operator demonstrates"),
                           ("nominal", "the expert's demonstrations, retargeted")):  # fmt: skip
        own = policies[policies.variant == variant]
        units = 100 * own.groupby(["kp", "kd", "collection"]).success.mean()
        (shown,) = re.findall(rf"^\| {words} \|(.*)\|$", text, flags=re.M)
        for cell, corner in zip(shown.split("|"), corners, strict=True):
            of_corner = units.loc[corner]
            assert len(of_corner) == 5
            assert cell.strip().startswith(f"{of_corner.mean():.1f} %")
            if "(" in cell:
                assert f"({of_corner.min():.0f} to {of_corner.max():.0f})" in cell
    operated = policies[policies.variant == "operator"].groupby(["kp", "kd", "collection"])
    success = operated.success.mean()
    lead = over_collections((success.loc[32, 128] - success.loc[2048, 128]).to_numpy())
    ends = with_minus(f"({100 * lead.lower:.1f} to {100 * lead.upper:.1f} by Student's t)")
    assert f"{100 * lead.value:.1f} points {ends}" in " ".join(text.split())
    tried = pd.read_csv(DATA / "end_to_end_operator.csv").query("kp == 32 and kd == 2")
    assert f"in {tried.successes.sum()} of {tried.attempts.sum()} at CU" in text


def test_the_table_of_failures_is_that_of_the_data():
    page = (ROOT / "docs/results_collections.md").read_text()
    table = pd.read_csv(DATA / "collections_failures.csv", keep_default_na=False)
    table = table[(table.kd >= 32) & (table.failure != "")].assign(co=table.kp <= 128)
    table["before"] = table.failure.isin(["not_grasped", "not_moved"])
    seen = set()
    for task, own in table.groupby("task"):
        counts = own.groupby(["before", "collection", "co"])["count"].sum().unstack(fill_value=0)
        # four cells of 100 rollouts
        shares = 100 * counts / 400
        cells = [f"{shares.loc[True][co].mean():.1f} %" for co in (True, False)]
        for before in (True, False):
            lead = over_collections((shares[True] - shares[False]).loc[before].to_numpy())
            ends = f"({lead.lower:+.1f} to {lead.upper:+.1f})"
            cells.append(with_minus(f"{lead.value:+.1f} {ends}"))
        assert f"| {heading(task)} | {' | '.join(cells)} |" in page
        seen.add(task)
    assert seen == set(ANEW_TASKS)


def test_what_tasks_forgive_is_that_of_the_data():
    text = " ".join((ROOT / "docs/results_collections.md").read_text().split())
    replays = pd.read_csv(DATA / "noisy_tasks.csv").assign(co=lambda rows: rows.kp <= 128)
    sums = replays.groupby(["task", "co"])[["successes", "replays"]].sum()
    noise = (100 * sums.successes / sums.replays).unstack()
    others = noise.drop("dishwasher")
    assert f"at SO in {noise[False]['dishwasher']:.1f} % there" in text
    assert f"{others[False].min():.1f} to {others[False].max():.1f} % in the five other" in text
    assert f"at CO in {noise[True].min():.1f} to {noise[True].max():.1f} %" in text
    policies = pd.read_csv(DATA / "collections.csv").query("variant == 'nominal' and kd >= 32")
    success = policies.groupby(["task", policies.kp <= 128]).success.mean().unstack()
    gains, leads = (one[True] - one[False] for one in (noise, success))
    rho, p = rank_correlation(gains.to_numpy(), leads.to_numpy(), 1)
    assert f"ρ is {rho:.2f}, p {p:.2f}" in text


def test_what_the_page_on_errors_says_of_other_tasks_is_in_the_data():
    policies = pd.read_csv(DATA / "collections.csv").query("variant == 'nominal'")
    text = " ".join((ROOT / "docs/results_errors.md").read_text().split())
    told, leads = [], {}
    for task, own in policies[policies.task != "block_stack"].groupby("task"):
        cells = with_errors(by_collection(own, grid_of(own, "cloning"), LOSS))
        each = [
            [np.array(column) for column in (one.effective, one.kd / one.kp, one.success)]
            for _, one in cells.groupby("collection")
        ]
        told.append(np.mean([spearman(effective, success) for effective, _, success in each]))
        leads[task] = over_collections(np.array([stronger(*one) for one in each]))
    assert with_minus(f"ρ {max(told):.2f} to {min(told):.2f}") in text
    for task, lead in leads.items():
        value, *ends = abs(lead.value), abs(lead.lower), abs(lead.upper)
        assert f"{value:.2f}, {min(ends):.2f} to {max(ends):.2f})" in text, task
    assert [task for task, lead in leads.items() if lead.upper < 0] == ["dishrack_loading"]
    assert all(lead.lower > 0 for task, lead in leads.items() if task != "dishrack_loading")


def test_the_table_of_the_decision_is_that_of_the_data(made):
    decision, _ = made["transfer_decision"]
    text = (ROOT / "docs/results_transfer.md").read_text()
    kp, kd, jitter = decision.iloc[:3].itertuples()
    assert f"| +{kp.found:.2f} ± {kp.error:.2f} | {kp.p:.3f} | yes |" in text
    assert f"| −{-kd.found:.2f} ± {kd.error:.2f} | {kd.p:.3f} | **no" in text
    assert f"| +{100 * jitter.found:.0f} point | {jitter.p:.3f} | no |" in text


def test_the_page_on_errors_has_what_is_known_before_training(made):
    page = (ROOT / "docs/results_errors.md").read_text()
    printed = {name: text for name, (_, text) in made.items() if name.startswith("beforehand")}
    assert len(printed) == 2
    for text in printed.values():
        assert text.to_markdown(index=False, disable_numparse=True) in page


@pytest.mark.parametrize(
    ("words", "grid"),
    [
        ("Block Stack", "cloning_grid"), ("Dishwasher", "dishwasher"), ("Mug", "mug_hanging"),
        ("Dishrack, loading", "dishrack_loading"), ("Handover", "bimanual_handover"),
        ("Dishrack, unloading", "dishrack_unloading"), ("Block Stack, UR5e", "ur5e"),
    ],
)  # fmt: skip
def test_what_tells_success_in_each_grid_is_that_of_the_data(made, words, grid):
    table, _ = made["effective_error"]
    own = table[table.grid == grid].set_index("predictor")
    error, loss, ratio = own.loc[["effective_error", "loss", "damping_over_stiffness"]].itertuples()
    page = (ROOT / "docs/results_errors.md").read_text()
    (shown,) = re.findall(rf"^\| {words} \| (\d+) \|(.*)\|$", page, flags=re.M)
    cells = [cell.strip() for cell in shown[1].split("|")]
    spans = [f"{r.rho:+.2f} ({r.low:+.2f} to {r.high:+.2f})" for r in (error, ratio)]
    told = [spans[0], f"{loss.rho:+.2f}", spans[1]]
    assert cells == [with_minus(text) for text in told]
    assert int(shown[0]) == error.cells


def test_the_page_on_errors_says_how_much_difficulty_and_loss_differ(made):
    page = " ".join((ROOT / "docs/results_errors.md").read_text().split())
    of_kind = [
        table.query("predictor == 'label_difficulty' and task != 'mean over tasks'")
        for name, (table, _) in made.items()
        if name.startswith("beforehand")
    ]
    positions, displacements = of_kind
    loss, first, second = (
        f"{values.min():.0f} to {values.max():.0f}"
        for values in (positions.factor_loss, positions.factor, displacements.factor)
    )
    assert f"differs by a factor of {loss} from cell to cell" in page
    assert f"difficulty of positions by {first}, and that of displacements by {second}" in page
    for table in of_kind:
        told = ", ".join(f"{rho:+.2f}" for rho in table.rho_loss)
        assert told in page or " and ".join(told.rsplit(", ", 1)) in page
    size, other = (
        f"{t.over_loss.min():.1f} to {t.over_loss.max():.1f}" for t in (displacements, positions)
    )
    assert f"({size} times it in the median cell, not {other} times)" in page


@pytest.fixture(scope="module")
def anew():
    """Per cent points of collections drawn anew, a row a task and a variant."""
    table = collections(DATA).set_index("name")
    numbers = table.filter(regex="^(co_|success)") * 100
    return table.assign(**numbers)


def interval(row, key):
    """A lead with its interval, or the lag of the other side, as pages tell it."""
    value, *ends = abs(row[key]), abs(row[f"{key}_lower"]), abs(row[f"{key}_upper"])
    return f"{value:.1f} ({min(ends):.1f} to {max(ends):.1f})"


def without_units(text):
    """A page on one line, whose numbers stand beside their intervals."""
    return re.sub(r"(?: per cent)? points \(", " (", " ".join(text.split()))


@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("README.md", ["Block Stack, 50 epochs", "Block Stack, 150 epochs",
                       "Dishwasher, 150 epochs"]),
        ("docs/objections.md", ["Block Stack, 50 epochs", "Block Stack, 150 epochs",
                                "Dishwasher, 150 epochs", "Block Stack, 900 demonstrations"]),
        ("docs/results_collections.md", ["Block Stack, 900 demonstrations"]),
    ],
)  # fmt: skip
def test_pages_say_by_how_much_co_leads_in_collections_drawn_anew(anew, page, names):
    text = without_units((ROOT / page).read_text())
    for name in names:
        assert interval(anew.loc[name], "co_so") in text, name


def test_what_the_page_says_of_collections_is_in_their_table(anew):
    text = without_units((ROOT / "docs/results_collections.md").read_text())
    whole = anew[anew.index.str.endswith(" 150 epochs")]
    told = whole[whole.verdict != "cannot be told"]
    for name, row in told.iterrows():
        assert interval(row, "co_so") in text, name
    assert "With the mug it cannot be told" in text
    assert list(whole.index[whole.verdict == "cannot be told"]) == ["Mug Hanging, 150 epochs"]
    assert list(whole.index[whole.verdict == "not reproduced"]) == ["Dishwasher, 150 epochs"]
    # without the stiffest gains, one task alone keeps its lead
    below = whole.co_so_below_1024_lower > 0
    assert list(whole.index[below]) == ["Dishrack Loading, 150 epochs"]
    for name in ("Dishrack Loading, 150 epochs", "Bimanual Handover, 150 epochs",
                 "Block Stack, 900 demonstrations"):  # fmt: skip
        assert interval(anew.loc[name], "co_so_below_1024") in text, name
    best = anew[anew.index.str.endswith("each cell's best length")]
    for _, row in best[best.verdict != "cannot be told"].iterrows():
        assert f"{abs(row.co_so):.1f}" in text.split("## Each cell at its best")[1]
    assert best.verdict.tolist().count("cannot be told") == 2
    fewer = ~anew.index.str.startswith("Block Stack") | anew.index.str.contains("900")
    assert set(anew.collections[fewer]) == {5}
    assert set(anew.collections[~fewer]) == {8}
    # of other gains between these
    sure = anew[~anew.index.str.contains("best")]
    assert list(sure.index[sure.co_so_crossed_lower > 0]) == [
        "Block Stack, 400 epochs", "Dishrack Unloading, 400 epochs", "Dishrack Loading, 50 epochs",
        "Dishrack Loading, 150 epochs", "Dishrack Loading, 400 epochs",
    ]  # fmt: skip
    assert list(sure.index[sure.co_so_crossed_upper < 0]) == [
        "Dishwasher, 50 epochs", "Dishwasher, 150 epochs",
    ]  # fmt: skip
    assert (anew.beta_kd_lower > 0).all()


def test_the_page_on_errors_tells_what_tells_success_as_the_scoreboard_does(board):
    rows = board.set_index("id").loc[["effective_beats_loss", "effective_beats_ratio"]]
    text = " ".join((ROOT / "docs/results_errors.md").read_text().split())
    loss, ratio = rows.itertuples()
    told = with_minus(f"({loss.value:.2f}, {loss.lower:.2f} to {loss.upper:.2f})")
    assert f"validation error cannot be told {told}" in text
    assert f"by {-ratio.value:.2f} ({-ratio.upper:.2f} to {-ratio.lower:.2f})" in text
    assert (loss.verdict, ratio.verdict) == ("cannot be told", "not reproduced")
