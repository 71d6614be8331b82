"""First guesses: every effect at a few magnitudes, on all joints at once, in one batch."""

import logging
from collections.abc import Sequence

import numpy as np

from t2l.diagnose.inverse_dynamics_residual import missing_torque, motor_torque
from t2l.effects.blame import blaming, described, shipped
from t2l.effects.effect import Effect
from t2l.effects.term import Layout, Term
from t2l.errors import EffectError
from t2l.identify.first_guesses import check_guess, first_guesses
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor, Request
from t2l.identify.scales import scales

logger = logging.getLogger(__name__)


SCREENING_TOLERANCE = 5e-3  # numerics: relative decrease of the loss that counts as none

Start = tuple[Layout, np.ndarray, np.ndarray]


def candidate_layout(adopted: Layout, term: Term) -> Layout:
    """The adopted terms and `term`, in place of any of the same effect."""
    others = [other for other in adopted.terms if other.effect.name != term.effect.name]
    return Layout([*others, term])


def begun(term: Term, start: Start, so_far: LeastSquares) -> LeastSquares:
    """A fit from a first guess, with the derivatives by the model so far that it has without."""
    layout, u, size = start
    given = {key: c for key, c in so_far.columns().items() if key[0] != term.effect.name}
    return LeastSquares(
        layout, u, size, so_far.diagonal, tolerance=SCREENING_TOLERANCE, given=given
    )


def starting_points(
    predictor: Predictor,
    mask: np.ndarray,
    adopted: Layout,
    u_adopted: np.ndarray,
    effects: Sequence[Effect],
) -> dict[str, Start]:
    """By name, of each effect on all joints, what `starting_points_of` finds."""
    every = tuple(range(len(predictor.joints)))
    terms = [Term(effect, every) for effect in effects]
    found = starting_points_of(terms, predictor, mask, adopted, u_adopted)
    return {term.effect.name: start for term, (start, _) in zip(terms, found, strict=True)}


def starting_points_of(
    terms: Sequence[Term],
    predictor: Predictor,
    mask: np.ndarray,
    adopted: Layout,
    u_adopted: np.ndarray,
) -> list[tuple[Start, np.ndarray]]:
    """For each term its layout with the adopted ones, a start u and the size of its elements.

    And how far the mildest guess moves the simulation, (n,) rad at the samples of `mask`.

    Each joint takes the guess that lowers its own error most, a parameter of the robot the one
    that lowers the whole error; where none helps, the mildest.
    """
    adopted_values = {
        name: {parameter: value[0] for parameter, value in parameters.items()}
        for name, parameters in adopted.decode(u_adopted[None]).items()
    }
    njoint, samples = len(predictor.joints), predictor.samples
    layouts = [candidate_layout(adopted, term) for term in terms]
    so_far = predictor.predict([Request(adopted, u_adopted[None])])[0][0]
    effects = list({term.effect.name: term.effect for term in terms}.values())
    found_off = read_off(predictor, mask, effects, samples.q - so_far)
    sizes = scales(predictor)
    guesses = {e.name: first_guesses(e, sizes, njoint) + found_off[e.name] for e in effects}
    requests = [
        Request(
            layout,
            np.array(
                [
                    layout.encode({**adopted_values, term.effect.name: _on_joints(term, guess)})
                    for guess in guesses[term.effect.name]
                ]
            ),
        )
        for term, layout in zip(terms, layouts, strict=True)
    ]
    predicted = _predicted(terms, requests, predictor)
    residual = (so_far - samples.q)[mask]
    joint = samples.joint[mask]
    found = []
    for term, layout, q in zip(terms, layouts, predicted, strict=True):
        effect, starts = term.effect, guesses[term.effect.name]
        changed = (q - samples.q)[:, mask]
        _check_some_runs(effect, changed)
        values = _on_joints(term, choose(effect, starts, residual, changed, joint, njoint))
        size = _sizes(layout, effect, [_on_joints(term, s) for s in starts], adopted_values)
        start = layout, layout.encode({**adopted_values, effect.name: values}), size
        found.append((start, _mildest(changed - residual)))
    return found


def _predicted(
    terms: Sequence[Term], requests: Sequence[Request], predictor: Predictor
) -> list[np.ndarray]:
    """Positions with each guess; on every tick where a guess has to be final."""
    final = [predictor.coarseness > 1 and _is_final(term.effect) for term in terms]
    found = {}
    for every_tick in (False, True):
        rows = [i for i, is_final in enumerate(final) if is_final == every_tick]
        if rows:
            simulator = predictor.of(predictor.recordings, 1) if every_tick else predictor
            found |= zip(rows, simulator.predict([requests[i] for i in rows]), strict=True)
    return [found[i] for i in range(len(terms))]


def _is_final(effect: Effect) -> bool:
    """Whether nothing refines a first guess: neither derivatives nor a search."""
    return not effect.rough_error and all(p.rough for p in effect.parameters)


def _mildest(responses: np.ndarray) -> np.ndarray:
    """The least of responses (m, n), but for those that are none; zero if there is no other."""
    size = np.sqrt(np.mean(np.nan_to_num(responses, nan=np.inf) ** 2, axis=1))
    size = np.where(size > 1e-9, size, np.inf)  # rad
    least = int(np.argmin(size))
    return responses[least] if np.isfinite(size[least]) else np.zeros(responses.shape[1])


def _on_joints(term: Term, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Of values for all joints those that `term` has."""
    joints = list(term.joints)
    return {
        p.name: np.ravel(values[p.name])[joints]
        if p.per_joint and np.size(values[p.name]) > 1
        else values[p.name]
        for p in term.effect.parameters
    }


def _check_some_runs(effect: Effect, error: np.ndarray) -> None:
    """Whether the model with an effect can be simulated at all; error (m, nsample) of m guesses."""
    if np.isfinite(error).all(axis=1).any():
        return
    if shipped(effect):
        logger.warning("%s: left out, the model runs away with every first guess", effect.name)
        return
    raise EffectError(
        f"effect {described(effect)}: found no finite motion with any of its {len(error)} first "
        "guesses; allowed: torques and parameters that a simulation can run with"
    )


def read_off(
    predictor: Predictor, mask: np.ndarray, effects: Sequence[Effect], residual: np.ndarray
) -> dict[str, list[dict[str, np.ndarray]]]:
    """Guesses of each effect, at most one, from the torque that the model so far lacks."""
    readers = [e for e in effects if type(e).read_off is not Effect.read_off]
    guesses: dict[str, list] = {effect.name: [] for effect in effects}
    if not readers:
        return guesses
    torque, samples = missing_torque(predictor, residual), predictor.samples
    clock = samples.time + np.array([r.time[0] for r in predictor.recordings])[samples.recording]
    motor = motor_torque(predictor) if any(e.reads_motor for e in readers) else None
    where = [mask & (samples.joint == j) for j in range(len(predictor.joints))]
    for effect in readers:
        with blaming([effect], "to read a first guess off (read_off)"):
            of_joints = [
                effect.read_off(
                    samples.q[at],
                    torque[at],
                    clock[at],
                    **({"motor": motor[at]} if effect.reads_motor else {}),
                )
                for at in where
            ]
            if any(found is None for found in of_joints):
                continue
            names = [parameter.name for parameter in effect.parameters]
            guess = {name: np.array([found[name] for found in of_joints]) for name in names}
            check_guess(effect, guess, len(of_joints))
        guesses[effect.name].append(guess)
    return guesses


def choose(
    effect: Effect,
    starts: Sequence[dict[str, np.ndarray]],
    residual: np.ndarray,
    changed: np.ndarray,
    joint: np.ndarray,
    njoint: int,
) -> dict[str, np.ndarray]:
    """For each joint the guess that helps it most, for what all share the one that helps most.

    Args:
        starts: m guesses.
        residual: (nsample,) rad, without the effect.
        changed: (m, nsample) rad, with each guess.
        joint: (nsample,) index of each sample's joint.

    Returns:
        Each parameter, (njoint,) or (1,).
    """
    squares = np.nan_to_num(changed**2, nan=np.inf)
    per_joint = np.stack([squares[:, joint == j].sum(axis=1) for j in range(njoint)], axis=1)
    before = np.array([(residual[joint == j] ** 2).sum() for j in range(njoint)])
    # joints that no guess helps do not vote on what all share
    shared = [p for p in effect.parameters if not p.per_joint]
    vote = per_joint if len(shared) == len(effect.parameters) else np.minimum(per_joint, before)
    alike: dict[tuple, list[int]] = {}
    for i, start in enumerate(starts):
        alike.setdefault(tuple(np.ravel(start[p.name])[0] for p in shared), []).append(i)
    # where none is helped, the least harm decides
    members = min(
        alike.values(),
        key=lambda rows: (vote[rows].min(axis=0).sum(), per_joint[rows].min(axis=0).sum()),
    )
    choice = np.array(members)[np.argmin(per_joint[members], axis=0)]
    values = {
        p.name: np.array(
            [np.broadcast_to(starts[choice[j]][p.name], njoint)[j] for j in range(njoint)]
        )
        if p.per_joint
        else starts[members[0]][p.name]
        for p in effect.parameters
    }
    for j in range(njoint):
        at = joint == j
        if per_joint[choice[j], j] >= before[j]:
            share = _share(residual[at], changed[choice[j]][at] - residual[at])
            for p in effect.parameters:
                if p.per_joint and not p.log and np.isfinite(p.neutral):
                    values[p.name][j] = p.neutral + share * (values[p.name][j] - p.neutral)
    return values


def _share(residual: np.ndarray, change: np.ndarray) -> float:
    """How much of a guess that overshoots to take, were the response linear in it."""
    size = float(change @ change)
    if not np.isfinite(size) or size == 0:
        return 0.05  # guess: where the guess itself says nothing
    return float(np.clip(-(residual @ change) / size, 0.01, 1.0))  # guess: at least


def _sizes(layout: Layout, effect: Effect, starts, adopted_values) -> np.ndarray:
    """Magnitude of each element of u: of an adopted value, or of the first guesses."""
    sizes = []
    for slot in layout.slots:
        name = slot.parameter.name
        if slot.term.effect.name == effect.name:
            guesses = [np.broadcast_to(s[name], slot.term.width(slot.parameter)) for s in starts]
            at = slot.term.joints.index(slot.joint) if slot.joint is not None else 0
            sizes.append(max(np.median([abs(g[at]) for g in guesses]), slot.size))
        else:
            adopted = np.abs(adopted_values[slot.term.effect.name][name]).mean()
            sizes.append(max(adopted, slot.size))
    # numerics: of the range
    least = np.array([1e-4 * (s.upper - s.lower) for s in layout.slots])
    # numerics: of the scale, at most
    most = np.array([1e-2 * s.scale for s in layout.slots])
    return np.maximum(np.array(sizes), np.minimum(least, most))
