"""What a file of config/tasks/ may say of Mug Hanging."""

from pydantic import Field

from t2l.tasks.table_top import Range, TableTopParameters
from t2l.typed import Number


class MugHangingParameters(TableTopParameters):
    """Arguments of `t2l.tasks.mug_hanging.MugHanging`."""

    mug_diameter_m: Number = Field(ge=0.03, le=0.2, description="of the mug without handle, m")
    handle_opening_m: Number = Field(
        ge=0.01, le=0.05, description="edge of the square that the handle leaves open, m"
    )
    peg_diameter_m: Number = Field(ge=0.004, le=0.06, description="of the pegs, m")
    mug_x_m: Range = Field(description="where the mug starts, [low, high], m")
    mug_y_m: Range = Field(description="where the mug starts, [low, high], m")
    mug_yaw_rad: Number = Field(ge=0, le=1.2, description="the mug starts turned up to it, rad")
