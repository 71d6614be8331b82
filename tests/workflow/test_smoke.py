import copy
import json
import os
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

CELLS = ["kp32_kd2", "kp512_kd2", "kp32_kd32", "kp512_kd32"]


def _changed(project, section, **keys):
    config = copy.deepcopy(project.config)
    config[section].update(keys)
    return config


def test_every_figure_and_table_is_there(smoke):
    for name in ("success", "replay", "fidelity", "tracking", "frames"):
        figure = smoke.results / "figures" / f"block_stack_{name}"
        assert imread(figure.with_suffix(".png"))[..., :3].std() > 0.02
        assert figure.with_suffix(".pdf").read_bytes().startswith(b"%PDF")
    for suffix in ("csv", "md", "tex"):
        assert (smoke.results / "tables" / f"behaviour_cloning.{suffix}").stat().st_size > 100
    assert "Block Stack" in (smoke.results / "tables" / "behaviour_cloning.md").read_text()


def test_noise_on_commands_is_in_figures_and_tables(smoke):
    for name in ("attenuation", "effective_error", "block_stack_noise", "block_stack_noise_traces"):
        assert imread(smoke.results / "figures" / f"{name}.png")[..., :3].std() > 0.02
    noise = pd.read_csv(smoke.results / "tables" / "noise.csv").set_index("condition")
    assert noise.index.tolist() == ["none", "same", "own"]
    assert (noise.cells == len(CELLS)).all()
    # one magnitude in every cell, and one of each cell's own
    assert noise.smallest_rad["same"] == noise.largest_rad["same"]
    assert noise.smallest_rad["own"] < noise.largest_rad["own"]
    told = pd.read_csv(smoke.results / "tables" / "effective_error.csv")
    assert set(told.predictor) == {"effective_error", "loss", "damping_over_stiffness"}
    held = pd.read_parquet(smoke.results / "attenuation" / "held_noise.parquet")
    assert len(held) == len(CELLS) * (len(smoke.config["attenuation"]["inertias_kg_m2"]) + 1)


def test_the_studys_grids_stand_beside_ours_where_they_are_given(copied):
    gains, rows = [8, 32, 128], np.arange(9.0).reshape(3, 3)
    grid = {"validation": rows / 10, "replay": 0 * rows + 1, "loss": 1 + rows**2}
    page = {"kps": gains, "kds": gains} | {key: rows.tolist() for key, rows in grid.items()}
    (copied.folder / "page.json").write_text(json.dumps({"taskData": {"Mug Hanging": page}}))
    config = _changed(copied, "attenuation", published_grids="page.json")
    path = "results/smoke/tables/effective_error.csv"
    assert copied.run("--", path, config=config).returncode == 0
    assert "study: Mug Hanging" in set(pd.read_csv(copied.folder / path).grid)


def test_one_row_per_rollout_with_its_kind_of_failure(smoke):
    rollouts = pd.read_parquet(smoke.results / "block_stack" / "nominal" / "rollouts.parquet")
    assert len(rollouts) == len(CELLS) * smoke.config["rollouts"]["count"]
    assert set(zip(rollouts.kp, rollouts.kd, strict=True)) == {
        (32, 2),
        (512, 2),
        (32, 32),
        (512, 32),
    }
    assert ((rollouts.failure == "") == rollouts.success).all()
    assert (rollouts.time_to_success_s.notna() == rollouts.success).all()


def test_progress_says_what_is_done_and_what_is_left(smoke):
    lines = re.findall(r"^ *(\d+) of (\d+)  (.+)$", smoke.first.stdout, re.MULTILINE)
    numbers, totals, texts = zip(*lines, strict=True)
    assert set(totals) == {str(len(lines))}
    assert [int(n) for n in numbers] == list(range(1, len(lines) + 1))
    assert re.search(r"train block_stack nominal kp\d+_kd\d+ 0  \d+ s", smoke.first.stdout)
    # from a quarter of the jobs on, at the latest, every line but the last says how long
    assert all(re.search(r"; about .+ left$", text) for text in texts[len(texts) // 4 : -1])


def test_a_second_run_does_nothing_and_says_so(smoke):
    before = smoke.artefacts()
    again = smoke.run("--", "all")
    assert again.returncode == 0
    assert "Nothing to be done" in again.stdout
    assert smoke.artefacts() == before


# what takes long; tables and figures follow
WORK = ("demonstrate", "retarget", "fidelity", "train", "roll_out", "noisy_replays", "held_noise")
WORK += ("identify", "tune", "train_policy", "deploy", "decouple")


@pytest.mark.parametrize(
    ("section", "keys", "rules"),
    [
        ("rollouts", {"count": 9}, {"roll_out": 4, "noisy_replays": 4}),
        ("training", {"epochs": 5}, {"train": 4, "roll_out": 4, "noisy_replays": 4}),
        ("fidelity", {"decimations": [1, 5]}, {"fidelity": 2}),
        ("grid", {"compliant_up_to_kp": 64}, {}),
        (
            "grid",
            {"kp": [32, 64, 512]},
            {"retarget": 2, "train": 2, "roll_out": 2, "noisy_replays": 6, "held_noise": 1},
        ),
    ],
    ids=["rollouts", "epochs", "decimations", "split", "a new column"],
)
def test_a_changed_parameter_reruns_what_depends_on_it_and_nothing_else(
    smoke, section, keys, rules
):
    planned = smoke.planned(config=_changed(smoke, section, **keys))
    assert {rule: n for rule, n in planned.items() if rule in WORK} == rules
    assert ("fidelity_figure" in planned) == (section == "fidelity")
    assert ("statistics" in planned) == (section != "fidelity")


def test_a_changed_task_reruns_everything(copied):
    path = copied.folder / "config/tasks/block_stack.yaml"
    path.write_text(path.read_text().replace("horizon_s: 8.0", "horizon_s: 7.0"))
    planned = copied.planned()
    assert planned["demonstrate"] == 1
    assert planned["train"] == planned["roll_out"] == planned["retarget"] == 4


def test_one_deleted_artefact_rebuilds_that_cell_alone(copied):
    (copied.results / "block_stack/nominal/kp32_kd32/seed0/policy.safetensors").unlink()
    planned = copied.planned()
    assert (planned["train"], planned["roll_out"]) == (1, 1)
    assert set(planned) & set(WORK) == {"train", "roll_out", "noisy_replays"}


def test_a_cell_is_written_for_lerobot_on_request(copied):
    cell = copied.results / "block_stack" / "nominal" / "kp32_kd2"
    assert not (cell / "demonstrations").exists()
    target = "results/smoke/block_stack/nominal/kp32_kd2/demonstrations"
    assert copied.planned(target) == {"dataset": 1}
    done = copied.run("--", target)
    assert done.returncode == 0, done.stdout[-3000:]
    told = json.loads((cell / "demonstrations/meta/info.json").read_text())
    episodes = pd.read_parquet(cell / "episodes.parquet")
    assert (told["total_frames"], told["fps"]) == (len(episodes), 50)
    assert copied.planned("datasets") == {"dataset": 3, "datasets": 1}


def _appears(path):
    deadline = time.monotonic() + 90
    while not path.exists():
        assert time.monotonic() < deadline, f"{path} did not appear"
        time.sleep(0.05)


def test_one_cell_is_one_path_and_comes_out_the_same_after_a_kill(copied):
    cell = copied.results / "block_stack" / "nominal" / "kp512_kd32"
    logs = copied.results / "logs"
    target = "results/smoke/block_stack/nominal/kp512_kd32/seed0/rollouts.parquet"
    before, artefacts = pd.read_parquet(cell / "seed0/rollouts.parquet"), copied.artefacts()
    weights = (cell / "seed0/policy.safetensors").read_bytes()
    shutil.rmtree(cell)
    retargeting = logs / "retarget/block_stack_nominal_kp512_kd32.log"
    training = logs / "train/block_stack_nominal_kp512_kd32_seed0.log"
    retargeting.unlink()
    training.unlink()
    said = copied.folder / "said.txt"
    with said.open("w") as stream:
        run = subprocess.Popen(
            copied.command("--", target),
            cwd=copied.folder,
            start_new_session=True,
            stdout=stream,
            stderr=stream,
        )
    _appears(retargeting)
    # a second run in the same folder is refused while the first is alive, which waits for it
    os.killpg(run.pid, signal.SIGSTOP)
    second = copied.run("--", target)
    os.killpg(run.pid, signal.SIGCONT)
    assert second.returncode != 0
    assert "another run is at work here" in second.stdout
    _appears(training)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    plan = re.search(r"^3 jobs: (.+)$", said.read_text(), re.MULTILINE)[1]
    assert set(plan.split(", ")) == {"1 retarget", "1 train", "1 roll_out"}
    retargeted = (cell / "replays.parquet").stat().st_mtime_ns
    assert not (cell / "seed0/policy.safetensors").exists()
    assert not (cell / "seed0/losses.parquet").exists()

    resumed = copied.run("--", target)
    assert resumed.returncode == 0, resumed.stdout[-4000:]
    assert not re.search(r" of \d+  (demonstrate|retarget) ", resumed.stdout)
    assert (cell / "replays.parquet").stat().st_mtime_ns == retargeted
    pd.testing.assert_frame_equal(pd.read_parquet(cell / "seed0/rollouts.parquet"), before)
    assert (cell / "seed0/policy.safetensors").read_bytes() == weights
    changed = {p for p, t in copied.artefacts().items() if artefacts.get(p) != t}
    assert all(p.startswith("block_stack/nominal/kp512_kd32/") for p in changed)


def test_a_truncated_artefact_is_named_and_made_anew(copied):
    path = copied.results / "block_stack" / "nominal" / "kp32_kd2" / "seed0" / "losses.parquet"
    path.write_bytes(path.read_bytes()[:-20])
    done = copied.run("--", "tables")
    assert done.returncode != 0
    assert "set aside as losses.parquet.broken; run again" in done.stdout
    losses = "results/smoke/block_stack/nominal/kp32_kd2/seed0/losses.parquet"
    assert f"{losses}: cannot be read" in done.stdout
    assert path.with_name("losses.parquet.broken").exists()
    planned = copied.planned()
    assert (planned["train"], planned["roll_out"], planned["summarise"]) == (1, 1, 1)


def test_the_report_shows_every_figure_with_its_caption(smoke):
    done = smoke.run("--report", "report.html", "--", "all")
    assert done.returncode == 0, done.stdout[-3000:]
    page = (smoke.folder / "report.html").read_text()
    for name in ("success", "replay", "fidelity", "tracking", "frames"):
        assert f"block_stack_{name}.png" in page
    assert "behaviour_cloning.csv" in page
    assert "Bonferroni-corrected" in page
    assert "retargeted to its gains" in page


def test_memory_stays_below_two_gib(smoke):
    peaks = {
        path.parent.name: pd.read_csv(path, sep="\t").max_rss.max()
        for path in smoke.results.glob("benchmarks/*/*.tsv")
    }
    assert set(peaks) >= {"demonstrate", "retarget", "train", "roll_out"}
    assert max(peaks.values()) < 2048, json.dumps(peaks)
