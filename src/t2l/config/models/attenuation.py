"""The section about what controllers leave of errors of commands."""

from typing import Annotated

from pydantic import Field

from t2l.config.quantities import Given, Positive, Text
from t2l.typed import Integer, Number, Typed, Unique

# as light as a small motor's rotor, as heavy as a stretched arm
Inertia = Annotated[Number, Field(gt=0, ge=1e-4, le=100)]


class Attenuation(Typed):
    """Of noise on commands."""

    noise_rad: Number = Field(
        0.01,
        gt=0,
        ge=1e-6,
        le=1,
        description="standard deviation of the noise on the command of a joint that holds a pose, "
        "rad",
    )
    inertias_kg_m2: Annotated[list[Inertia], Field(min_length=1, max_length=20), Unique] = Field(
        [0.02, 0.1, 0.5],
        description="inertias of bare joints, kg·m²; the last joint of `robot.name` is another",
    )
    replicates: Integer = Field(
        64, ge=2, le=100_000, description="simulated joints of each kind in each cell"
    )
    time_constants: Positive = Field(
        10,
        le=1000,
        description="how long the variance is measured, in time constants of each cell",
    )
    replays: Integer = Field(
        50, ge=1, le=5_000, description="replays under noise in each cell, for each kind of noise"
    )
    published_grids: Annotated[Text | None, Given] = Field(
        None,
        description="a download of the file of results that the study's project page shows, for "
        "the same statistics of the study's own cells, and how ours are ordered beside them; see "
        "docs/results_errors.md",
    )
