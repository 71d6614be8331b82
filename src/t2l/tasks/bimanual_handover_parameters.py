"""What a file of config/tasks/ may say of the bimanual handover."""

from pydantic import Field

from t2l.tasks.table_top import Range, TableTopParameters
from t2l.typed import Number


class BimanualHandoverParameters(TableTopParameters):
    """Arguments of `t2l.tasks.bimanual_handover.BimanualHandover`."""

    robot: str = Field("fr3_duo", description="name of a robot of two arms with grippers")
    # below, there is no room for two hands
    bar_length_m: Number = Field(ge=0.2, le=0.5, description="of what is handed over, m")
    bar_width_m: Number = Field(ge=0.01, le=0.2, description="of it, where it is grasped, m")
    # above, it meets the palm
    bar_height_m: Number = Field(ge=0.03, le=0.06, description="of it, as it lies, m")
    bar_mass_kg: Number = Field(gt=0, le=5, description="mass of the bar, kg")
    bar_x_m: Range = Field(description="where its middle lies at the start, [low, high], m")
    bar_y_m: Range = Field(description="where its middle lies at the start, [low, high], m")
    bar_yaw_rad: Number = Field(ge=0, le=0.8, description="the bar is turned up to it, rad")
