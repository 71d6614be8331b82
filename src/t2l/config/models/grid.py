"""Grids of gains, which both chains run over."""

from typing import Annotated

from pydantic import Field

from t2l.config.quantities import AscendingGains, Positive
from t2l.typed import Typed

Stiffnesses = Annotated[AscendingGains, Field(description="stiffnesses Kp, N·m/rad, ascending")]
Dampings = Annotated[AscendingGains, Field(description="dampings Kd, N·m·s/rad, ascending")]
CompliantUpTo = Annotated[
    Positive, Field(description="largest stiffness that counts as compliant, N·m/rad")
]
OverdampedFrom = Annotated[
    Positive, Field(description="smallest damping that counts as overdamped, N·m·s/rad")
]


class Grid(Typed):
    """Cells, one for each pair of gains, and where a region of them begins."""

    kp: Stiffnesses
    kd: Dampings
    compliant_up_to_kp: CompliantUpTo
    overdamped_from_kd: OverdampedFrom
