"""What cloned policies see."""

from typing import Annotated

from pydantic import Field

from t2l.typed import Integer, Name, Typed, Unique


class Observation(Typed):
    """Of cloned policies."""

    cameras: Annotated[list[Name], Field(max_length=10), Unique] = Field(
        [],
        description="cameras of the task's scene, such as `global` and `wrist`, whose pictures a "
        "policy sees beside the robot's own state; without any it sees the state of everything",
    )
    # smaller than 16, and no block is a pixel; larger, and training takes a machine for itself
    size_px: Integer = Field(
        96, ge=16, le=512, description="width and height of the cameras' pictures, pixels"
    )
