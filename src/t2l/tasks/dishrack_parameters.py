"""What a file of config/tasks/ may say of a dish rack."""

from pydantic import Field

from t2l.tasks.table_top import Range, TableTopParameters
from t2l.typed import Number


class DishrackParameters(TableTopParameters):
    """Arguments of `t2l.tasks.dishrack.Dishrack`."""

    plate_thickness_m: Number = Field(ge=0.002, le=0.2, description="of the plate's rim, m")
    plate_mass_kg: Number = Field(gt=0, le=1, description="mass of the plate, kg")
    # in a wider one a plate leans too far to count as upright
    slot_width_m: Number = Field(gt=0, le=0.04, description="between two walls of the rack, m")
    rack_x_m: Range = Field(description="where the slot starts, [low, high], m")
    rack_y_m: Range = Field(description="where the slot starts, [low, high], m")
    pad_x_m: Range = Field(description="where the pad starts, [low, high], m")
    pad_y_m: Range = Field(description="where the pad starts, [low, high], m")
    yaw_rad: Number = Field(ge=0, le=0.5, description="rack and pad are turned up to it, rad")
