"""Numbers and lists as the page says them, in plain text; the templates escape it."""

from collections.abc import Iterable, Mapping, Sequence
from math import ceil, log10

from t2l.names import with_minus
from t2l.plotting.style import raised


def mrad(value: float | None) -> str:
    """Radians as milliradians with three digits."""
    if value is None:
        return "–"
    return f"{number(1e3 * value)} mrad"


def number(value: float, digits: int = 3) -> str:
    """Significant digits without an exponent where one can do without."""
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 1e6:
        text = f"{value:.{digits}g}"
        return with_minus(text if "e" not in text else f"{float(text):.0f}")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{with_minus(mantissa)} · 10{raised(str(int(exponent)))}"


def estimate(value: float, ci95: Sequence[float] | None) -> tuple[str, str]:
    """A value and its interval, with two digits of the interval's width."""
    if ci95 is None:
        return number(value), "–"
    width = ci95[1] - ci95[0]
    digits = 3
    if width > 0 and value != 0:
        digits = min(6, max(3, 2 + ceil(log10(abs(value) / width))))
    low, high = (number(bound, digits) for bound in ci95)
    return number(value, digits), low if low == high else f"{low} to {high}"


def span(values: Iterable[float], unit: str = "") -> str:
    """One value, or the smallest to the largest."""
    known = sorted(set(values))
    ends = [f"{value:g}" for value in (known[0], known[-1])]
    text = ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"
    return f"{text} {unit}".strip()


def readable(name: str) -> str:
    """An effect's name where its title is not known."""
    return name.replace("_", " ")


def title_in(name: str | None, titles: Mapping[str, str]) -> str:
    """An effect's title, or its name where no title is known."""
    return titles.get(name) or readable(name)


def gains(values: Sequence[float]) -> str:
    """One gain, or one for each joint where they differ."""
    return "/".join(f"{v:g}" for v in (values if len(set(values)) > 1 else values[:1]))


def sentence(text: str) -> str:
    """With a capital and a full stop, and true minus signs."""
    text = capital(with_minus(text.strip()))
    return text + ("" if not text or text[-1] in ".!?:" else ".")


def capital(text: str) -> str:
    """The first letter large, the others as they are."""
    return text[:1].upper() + text[1:]
