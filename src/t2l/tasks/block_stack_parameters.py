"""What a file of config/tasks/ may say of Block Stack."""

from pydantic import Field

from t2l.tasks.table_top import Range, TableTopParameters
from t2l.typed import Number


class BlockStackParameters(TableTopParameters):
    """Arguments of `t2l.tasks.block_stack.BlockStack`."""

    block_size_m: Number = Field(ge=0.01, le=0.2, description="edge of both cubes, m")
    block_mass_kg: Number = Field(gt=0, le=2, description="mass of each cube, kg")
    placement_tolerance_m: Number = Field(
        gt=0, le=0.05, description="largest distance of the centres that counts as stacked, m"
    )
    workspace_x_m: Range = Field(description="where cubes start, [low, high], m")
    workspace_y_m: Range = Field(description="where cubes start, [low, high], m")
    block_yaw_rad: Number = Field(ge=0, le=0.7854, description="cubes start turned up to it, rad")
