"""The section of the scoreboard."""

from typing import Annotated

from pydantic import Field

from t2l.typed import Name, Typed, Unique


class Scoreboard(Typed):
    """What its claims are judged by."""

    studies: Annotated[list[Name], Field(min_length=1, max_length=100), Unique] = Field(
        description="names of other studies whose results in `results/` are read too, in any "
        "order: each statement is judged by the study that is about it "
        "(docs/scoreboard_rules.md); those that were not run are left out"
    )
