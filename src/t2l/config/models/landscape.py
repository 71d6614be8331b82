"""The section of how easily action scales are found."""

from pydantic import Field

from t2l.typed import Integer, Number, Typed


class Landscape(Typed):
    """Of trials at the corners of `recording_grid`."""

    passed: Number = Field(
        0.95, gt=0, lt=1, description="success rate above which a trial passes, the study's"
    )
    exists: Number = Field(
        0.99, gt=0, le=1, description="success rate from which a solution exists, the study's"
    )
    # a job each, at every corner in every condition
    configurations: Integer = Field(
        5,
        ge=0,
        le=100,
        description="trials that are trained again at most: the first of those that pass; 0: none",
    )
    seeds: Integer = Field(5, ge=1, le=100, description="how often each of them")
