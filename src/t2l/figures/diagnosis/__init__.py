"""Where a model fails, as figures; each shows one model, or two: as it came and final."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from t2l.diagnose.files import FIGURES
from t2l.diagnose.fronts import fronts
from t2l.diagnose.results import Compared, errors_by_step, read_found
from t2l.figures.diagnosis.conditions import residual_by_condition
from t2l.figures.diagnosis.effects import error_falling, ranking
from t2l.figures.diagnosis.frequencies import spectrum
from t2l.figures.diagnosis.front import front
from t2l.figures.diagnosis.gains import error_by_cell
from t2l.figures.diagnosis.motion import overlays
from t2l.plotting.style import write

FORMATS = ("png", "pdf")


def draw_comparison(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l compare` found."""
    _draw(Path(folder), _of_comparison(read_found(folder).compared))


def draw_diagnosis(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l diagnose` found."""
    _draw(Path(folder), {"ranking": ranking(read_found(folder).diagnosis)})


def draw_explanation(folder: Path | str) -> None:
    """Draw into ``folder/figures`` what `t2l explain` found."""
    found = read_found(folder)
    floor = found.explanation["noise_floor_rad"]
    figures = {"error_falling": error_falling(errors_by_step(found), floor)}
    figures |= {f"front_{one.step}": front(one, floor) for one in fronts(found)}
    _draw(Path(folder), figures | _of_comparison(found.compared))


def _draw(folder: Path, figures: Mapping[str, Figure]) -> None:
    for name, figure in figures.items():
        write(figure, [folder / FIGURES / f"{name}.{suffix}" for suffix in FORMATS])


def _of_comparison(compared: Sequence[Compared]) -> dict[str, Figure]:
    if not compared:
        return {}
    return {
        "overlays": overlays(compared),
        "error_by_cell": error_by_cell(compared),
        "residual_by_condition": residual_by_condition(compared),
        "spectrum": spectrum(compared),
    }
