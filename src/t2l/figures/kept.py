"""Figures of the documentation, drawn from the tables that the repository keeps.

A figure is a function of the folder docs/data. What is rendered, such as frames, is not among them.
"""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from t2l.figures import ablation, fidelity, identification, transfer
from t2l.figures.collections import collections
from t2l.figures.learned_tasks import learned_tasks
from t2l.figures.learning import landscape
from t2l.figures.planted_worlds import planted_worlds
from t2l.figures.responses import responses
from t2l.figures.scaling import scaling
from t2l.figures.success import success_and_loss
from t2l.figures.variants import variants
from t2l.gains import Cell
from t2l.plotting.style import title
from t2l.stats.ablation import WHOLE
from t2l.stats.ablation import by_cell as ablation_by_cell
from t2l.stats.collections import by_collection, collections_table
from t2l.stats.planted import EXPLAINED, WITHIN, losses, reliability
from t2l.stats.regions import region_table
from t2l.stats.scaling import scaling_table
from t2l.stats.transfer import jitter_table
from t2l.study.attenuation import figures as attenuation
from t2l.study.attenuation.noise import magnitudes
from t2l.study.attenuation.statistics import effective_error_table
from t2l.study.attenuation.success import by_cell as means_by_cell
from t2l.study.attenuation.success import predictors
from t2l.study.decoupling.figures import stiffness_at_the_end
from t2l.study.kept.evidence import HOLD_S, demonstrations, deployed, named_collections, replays
from t2l.study.landscape.existence import existence_table
from t2l.study.landscape.figures import existence, sample_efficiency
from t2l.study.published.numbers import grid_of
from t2l.study.regimes import CLONING_COLUMNS, TRANSFER_COLUMNS, regimes
from t2l.transfer.summary import over_seeds

SIMULATION_RATE_HZ = 500
DPI = {
    "": 100,
    "identified_over_true": 200,
    "responses": 200,
}  # format: of PNG beside text; small print needs more
RULES = {
    "advised": "advice, machine known", "blind": "advice, nominal model",
    "critical": "critical damping at 5 Hz", "usual": "the gains it is used with",
    "left": "any of what is not ruled out, mean", "compliant": "compliant and overdamped, mean",
    "ratio": "largest Kd/Kp", "validation": "least validation loss",
}  # fmt: skip
TASKS = (
    "bimanual_handover", "dishrack_loading", "dishrack_unloading", "dishwasher", "mug_hanging",
)  # fmt: skip


def figures(folder: Path) -> Iterator[tuple[str, Figure]]:
    """Each figure by the name of its file, without the suffix."""
    for name, draw in FIGURES.items():
        yield name, draw(folder)


def _read(folder: Path, name: str) -> pd.DataFrame:
    return pd.read_csv(folder / f"{name}.csv")


def _success(folder: Path, name: str, task: str, variant: str = "nominal") -> Figure:
    table = _read(folder, name)
    heading = f"{title(task)}: behaviour cloning by controller gains"
    return success_and_loss(table[table.variant == variant], grid_of(table, "cloning"), heading)


def _variants(folder: Path) -> Figure:
    table = _read(folder, "variants")
    of_variant = {str(name): rows for name, rows in table.groupby("variant", sort=False)}
    return variants(region_table(of_variant, grid_of(table, "cloning")))


def _collections(folder: Path) -> Figure:
    table = _read(folder, "collections")
    grid = grid_of(table, "cloning")
    of_variant = named_collections(table)
    cells = {name: by_collection(rows, grid) for name, rows in of_variant.items()}
    return collections(collections_table(of_variant, grid), cells)


def _demonstrations(folder: Path) -> Figure:
    table = demonstrations(_read(folder, "demonstrations"))
    return scaling({"block_stack": scaling_table(table, grid_of(table, "cloning"))})


def _fidelity(folder: Path) -> Figure:
    heading = f"{title('block_stack')}: fidelity of torque-to-position retargeting"
    return fidelity.fidelity(replays(_read(folder, "fidelity")), SIMULATION_RATE_HZ, heading)


def _variance(folder: Path) -> Figure:
    table = _read(folder, "held_noise")
    return attenuation.variance(table, grid_of(table, "cloning"))


def _noise(folder: Path) -> Figure:
    cells = means_by_cell(_read(folder, "cloning_grid").query("variant == 'nominal'"))
    table = _read(folder, "noisy_replays").rename(columns={"mean": "success"})
    undisturbed = table[table.condition == "none"].rename(columns={"success": "replay_success"})
    noisy = table[table.condition != "none"]
    rows = noisy.loc[noisy.index.repeat(noisy["size"])]
    # every cell has the same
    largest = magnitudes(cells, Cell(cells.kp.iloc[0], cells.kd.iloc[0]))["same"]
    grid, heading = grid_of(cells, "cloning"), title("block_stack")
    return attenuation.noise_success(rows.assign(magnitude_rad=largest), undisturbed, grid, heading)


def _effective_error(folder: Path) -> Figure:
    table = _read(folder, "cloning_grid")
    grids = {"block_stack": means_by_cell(table[table.variant == "nominal"])}
    correlations = effective_error_table(grids, HOLD_S)
    shown = {name: predictors(cells, HOLD_S) for name, cells in grids.items()}
    return attenuation.success(shown, correlations, grid_of(table, "cloning"))


def _transfer(folder: Path) -> Figure:
    table = _read(folder, "transfer_decision")
    whole = table[table.without.isna()].drop(columns="without")
    return transfer.error_maps({"joint_reach": over_seeds(whole)}, grid_of(table, "transfer"))


def _ablation(folder: Path) -> Figure:
    table = _read(folder, "transfer_decision")
    table = table.assign(effect=table.without.fillna(WHOLE))
    least = table[table.effect != WHOLE][["kp", "kd"]].drop_duplicates()
    rollouts = deployed(table.merge(least, on=["kp", "kd"]))
    effects = [WHOLE, *sorted(set(table.effect) - {WHOLE})]
    cells = ablation_by_cell({name: rollouts[rollouts.effect == name] for name in effects})
    grid = grid_of(table, "transfer")
    inside = {Cell(kp, kd): grid.region(Cell(kp, kd)) == "SO" for kp, kd in least.to_numpy()}
    return ablation.ablation(cells, inside)


def _regimes(folder: Path) -> Figure:
    cloned, learned = _read(folder, "cloning_grid"), _read(folder, "transfer_decision")
    return regimes(
        cloned[cloned.variant == "nominal"][[*CLONING_COLUMNS]], grid_of(cloned, "cloning"),
        learned[learned.without.isna()][[*TRANSFER_COLUMNS]], grid_of(learned, "transfer"),
    )  # fmt: skip


def _jitter(folder: Path) -> Figure:
    table = deployed(_read(folder, "transfer_rates"))
    by_rate = {str(hertz): rows for hertz, rows in table.groupby("policy_rate_hz")}
    rates = {name: float(name) for name in by_rate}
    return transfer.jitter_by_period(jitter_table(by_rate, rates))


def _scales(folder: Path) -> Figure:
    table = _read(folder, "transfer_search").query("updates == 1000").assign(state="complete")
    grid = grid_of(table, "transfer")
    trials = {cell: table[(table.kp == cell.kp) & (table.kd == cell.kd)] for cell in grid.corners}
    return landscape(trials, grid)


def _efficiency(folder: Path) -> Figure:
    table = _read(folder, "landscape_again")
    return sample_efficiency(table, grid_of(table, "transfer"))


def _identified(folder: Path) -> Figure:
    return identification.over_true(_read(folder, "identified_published"))


def _decoupling(folder: Path) -> Figure:
    return stiffness_at_the_end(_read(folder, "decoupling"))


def _responses(folder: Path) -> Figure:
    """Of the virtual FR3: steps, and the motion of identification, rad from home."""
    table = _read(folder, "responses")
    grid = grid_of(table, "transfer")
    motions = {
        str(name): {
            cell: part[(part.kp == cell.kp) & (part.kd == cell.kd)] for cell in grid.corners
        }
        for name, part in table.groupby("motion", sort=False)
    }
    return responses(motions, grid)


def _learned(folder: Path, task: str) -> Figure:
    return learned_tasks({task: _read(folder, f"learning_{task}")})


def _planted(folder: Path) -> Figure:
    """Of advice that knows the machine, beside what people use."""
    table, pairs = (_read(folder, f"planted_{name}") for name in ("advice", "pairs"))
    known = table[table.known == EXPLAINED]
    nominal = table[table.known != EXPLAINED].set_index(["half", "world"]).advised
    blind = nominal.loc[known.set_index(["half", "world"]).index].to_numpy()
    stated = reliability(pairs[pairs.known == EXPLAINED])
    return planted_worlds(losses(known.assign(blind=blind), RULES), stated, WITHIN)


def _existence(folder: Path) -> Figure:
    return existence(existence_table(_read(folder, "existence")))


FIGURES: dict[str, Callable[[Path], Figure]] = {
    "block_stack_success": partial(_success, name="cloning_grid", task="block_stack"),
    "block_stack_success_without_noise": partial(
        _success, name="cloning_grid", task="block_stack", variant="observation_noise_0"
    ),
    "block_stack_ur5e_success": partial(_success, name="ur5e", task="block_stack_ur5e"),
    **{f"{task}_success": partial(_success, name=task, task=task) for task in TASKS},
    "variants": _variants,
    "collections": _collections,
    "demonstrations": _demonstrations,
    "block_stack_fidelity": _fidelity,
    "attenuation": _variance,
    "block_stack_noise": _noise,
    "effective_error": _effective_error,
    "transfer_decision": _transfer,
    "transfer_ablation": _ablation,
    "regimes": _regimes,
    "jitter": _jitter,
    "action_scales": _scales,
    "sample_efficiency": _efficiency,
    "learning_lift_cube": partial(_learned, task="lift_cube"),
    "learning_open_drawer": partial(_learned, task="open_drawer"),
    "learning_track_velocity": partial(_learned, task="track_velocity"),
    "learning_in_hand_cube": partial(_learned, task="in_hand_cube"),
    "existence": _existence,
    "decoupling": _decoupling,
    "planted_worlds": _planted,
    "responses": _responses,
    "identified_over_true": _identified,
}
