"""Where an exception in a file of the user's becomes an error that names the effect."""

import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from inspect import getfile

from t2l.effects.effect import Effect
from t2l.errors import EffectError, T2LError
from t2l.waiting import by_a_person, told_if_slow


@contextmanager
def blaming(effects: Iterable[Effect], doing: str) -> Iterator[None]:
    """Run code of effects: what they raise, or a call to exit, becomes an `EffectError`.

    Args:
        effects: that take part.
        doing: what is asked of them, for the message.

    Raises:
        EffectError: naming effect, file, line and exception. An exception that no effect of the
            user's takes part in is passed on as it is.
    """
    own = [effect for effect in effects if not shipped(effect)]
    named = ", ".join(described(effect) for effect in own)
    try:
        with told_if_slow(f"effect {named}, {doing}") if own else nullcontext():
            yield
    except (T2LError, GeneratorExit):
        raise
    except (Exception, SystemExit, KeyboardInterrupt) as error:
        if not own or by_a_person(error):
            raise
        files = {getfile(type(effect)): effect for effect in own}
        said = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"
        frames = traceback.extract_tb(error.__traceback__)
        for frame in reversed(frames):
            if frame.filename in files:
                name = files[frame.filename].name
                where = f"{frame.filename}, line {frame.lineno}"
                raise EffectError(f"effect {name} ({where}): {doing} failed: {said}") from None
        raise EffectError(f"effect {named}: {doing} failed: {said}") from None


def shipped(effect: Effect) -> bool:
    """Whether an effect is one of this package."""
    return type(effect).__module__.startswith("t2l.effects.")


def described(effect: Effect) -> str:
    """An effect's name, and the file of one that is the user's own."""
    return effect.name if shipped(effect) else f"{effect.name} ({getfile(type(effect))})"
