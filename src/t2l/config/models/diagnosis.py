"""The section of the diagnosis."""

from typing import Annotated

from pydantic import Field

from t2l.config.quantities import Given, Paths, Text
from t2l.typed import Typed


class Diagnosis(Typed):
    """Of recordings."""

    recordings: Paths = Field(description="recordings, or folders of them, to fit")
    holdout: Annotated[Paths | None, Given] = Field(
        None,
        description="recordings to judge by; without them t2l holds out some of the first",
    )
    model: Annotated[Text | None, Given] = Field(
        None, description="the model so far; without it the robot as its MJCF says"
    )
    effects: Annotated[Paths | None, Given] = Field(
        None, description="Python files, or folders of them, with effects of your own"
    )
