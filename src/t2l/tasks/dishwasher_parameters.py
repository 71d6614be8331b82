"""What a file of config/tasks/ may say of the dishwasher."""

from pydantic import Field

from t2l.tasks.table_top import Range, TableTopParameters
from t2l.typed import Number


class DishwasherParameters(TableTopParameters):
    """Arguments of `t2l.tasks.dishwasher.Dishwasher`."""

    opened_rad: Number = Field(
        gt=0, le=1.4, description="angle from which on the door counts as open, rad"
    )
    door_friction_nm: Number = Field(ge=0, le=20, description="dry friction of the hinge, N·m")
    bar_diameter_m: Number = Field(ge=0.005, le=0.2, description="of what is grasped, m")
    front_x_m: Range = Field(description="where the front stands at the start, [low, high], m")
    front_y_m: Range = Field(description="where the front stands at the start, [low, high], m")
    yaw_rad: Number = Field(ge=0, le=0.5, description="the front is turned up to it, rad")
