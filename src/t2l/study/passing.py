"""When a trial of a search, or a policy in its own simulator, passes: the study's section V-B."""

PASSED = 0.95  # bound: success that the study asks for more than


def passes[Shares](success: Shares, bound: float = PASSED) -> Shares:
    """Whether a share of successful episodes, 0 to 1, or each of a column of them, is above."""
    return success > bound
