"""Lists in one word of a command line, such as ``1,2,3``."""


def words(text: str) -> list[str]:
    """Text between commas."""
    return [word.strip() for word in text.split(",")]


def integers(text: str) -> list[int]:
    """Whole numbers between commas."""
    return [int(word) for word in text.split(",")]


def numbers(text: str) -> float | list[float]:
    """Numbers between commas; one alone is no list."""
    found = [float(word) for word in text.split(",")]
    return found if len(found) > 1 else found[0]


# what argparse calls them where they are wrong
integers.__name__, numbers.__name__ = "whole numbers", "numbers"
