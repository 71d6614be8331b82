"""Linearise, screen, fit, judge, and again from what was adopted, until nothing earns its place."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from t2l.detective.candidates import known_candidates
from t2l.detective.data_split import DataSplit
from t2l.detective.fit import FittedSet, begun, fit_sets
from t2l.detective.linear_loop import linearised
from t2l.detective.motion import measured_motion
from t2l.detective.rule import Judge
from t2l.detective.screen import Screen
from t2l.diagnose.starting_points import _read_off
from t2l.effects.term import Layout, Term
from t2l.identify.block_bootstrap import blocks
from t2l.identify.first_guesses import first_guesses
from t2l.identify.model import Model, from_vector
from t2l.identify.noise_floor import noise_floor
from t2l.identify.scales import scales

ROUNDS = 6
FITTED = 8  # numerics: sets of a round that are fitted in full


@dataclass
class Found:
    model: Model
    steps: list = field(default_factory=list)
    log: list = field(default_factory=list)


def search(model: Model, data: DataSplit, coarseness: int = 4, say=lambda *a: None) -> Found:
    began = time.time()
    predictor, mask = data.fitted.of(data.fitted.recordings, coarseness), data.fitted_mask
    joints = predictor.joints
    samples = predictor.samples
    layout, u = model.vector(joints)
    block = blocks(samples.recording[mask], samples.time[mask])
    (current,) = fit_sets([(layout, u)], predictor, mask, data.folds, 0)
    found = Found(model)
    for number in range(ROUNDS):
        full = np.full(len(samples), np.nan)
        full[mask] = -current.residual
        residual = np.where(np.isnan(full), 0.0, full)
        floor = noise_floor(list(predictor.recordings), samples.by_row(full))
        judge = Judge(block, floor)
        say(
            f"[{time.time() - began:.1f}] round {number}: {1e3 * current.rmse:.3f} left out {1e3 * current.left_out_rmse:.3f} noise {1e3 * floor:.3f}"
        )
        if judge.quiet(current.left_out_rmse):
            break
        adopted = current.layout, current.u
        screen, table = _screen(model, predictor, mask, data, adopted, residual)
        say(f"[{time.time() - began:.1f}] columns {table.columns.shape}")
        front = screen.search()
        chosen = _to_fit(screen, front)
        say(
            f"[{time.time() - began:.1f}] "
            + " | ".join(
                f"{s.parameters}:{1e3 * np.sqrt(s.error):.3f} {[table.candidates[i] for i in s.members]}"
                for s in chosen
            )
        )
        starts = []
        for one in chosen:
            members = [table.candidates[i] for i in one.members]
            starts.append(begun(adopted, members, screen.weights(one.members), len(screen.base)))
        fits = [f for f in fit_sets(starts, predictor, mask, data.folds) if f is not None]
        for f in fits:
            say(
                f"   {f.parameters}: {1e3 * f.rmse:.3f} / {1e3 * f.left_out_rmse:.3f} {sorted(f.names)}"
            )
        better = choose(current, fits, judge)
        if better is None:
            break
        better = prune(better, current, predictor, mask, data.folds, judge, say)
        current = better
        found.steps.append(current)
        say(
            f"[{time.time() - began:.1f}] ADOPTED {sorted(current.names)} {1e3 * current.left_out_rmse:.3f}"
        )
    found.model = from_vector(model, current.layout, current.u, joints)
    found.log = [time.time() - began]
    return found


def choose(current: FittedSet, fits: Sequence[FittedSet], judge: Judge) -> FittedSet | None:
    """The set that the rule takes: of those alike with the best that of fewest parameters."""
    earning = [f for f in fits if judge.earns(current.left_out, f.left_out)]
    if not earning:
        return None
    best = min(f.left_out_rmse for f in earning)
    alike = [f for f in earning if judge.alike(f.left_out_rmse, best)]
    return min(alike, key=lambda f: (f.parameters, f.left_out_rmse))


def prune(better, current, predictor, mask, folds, judge, say) -> FittedSet:
    """Drop terms, joint by joint, that the rule does not miss."""
    while True:
        trials = []
        for term in better.layout.terms:
            lesser = [tuple(j for j in term.joints if j != gone) for gone in term.joints]
            if not any(p.per_joint for p in term.effect.parameters) or len(term.joints) == 1:
                lesser = [()]
            for joints in lesser:
                others = [t for t in better.layout.terms if t is not term]
                terms = [*others, Term(term.effect, joints)] if joints else others
                layout = Layout(terms)
                old = {s.key: v for s, v in zip(better.layout.slots, better.u, strict=True)}
                trials.append((layout, np.array([old[s.key] for s in layout.slots])))
        trials = [t for t in trials if t[0].terms]
        if not trials:
            return better
        fits = [f for f in fit_sets(trials, predictor, mask, folds) if f is not None]
        kept = [f for f in fits if not judge.earns(f.left_out, better.left_out)]
        if not kept:
            return better
        better = min(kept, key=lambda f: f.left_out_rmse)
        say(f"   pruned to {sorted(better.names)} {1e3 * better.left_out_rmse:.3f}")


def _to_fit(screen: Screen, front) -> list:
    """The front, and of each size what nearly is on it."""
    some = [s for s in front if s.members]
    singles = sorted(
        (s for s in screen.known.values() if len(s.members) == 1), key=lambda s: s.error
    )
    ranked = sorted((s for s in screen.known.values() if s.members), key=lambda s: s.error)
    chosen = []
    for s in [*some[: FITTED // 2], *singles[:4], *ranked[:2]]:
        if s not in chosen:
            chosen.append(s)
    return chosen[:10]


def _screen(model, predictor, mask, data, adopted, residual):
    layout, u = adopted
    motions = measured_motion(predictor, layout, u)
    sections = linearised(predictor, layout, u, motions)
    sizes = scales(predictor)
    effects = [
        e for e in model.known_effects(predictor.joints).values() if e.may_act(predictor.recordings)
    ]
    read = _read_off(predictor, mask, effects, residual)
    n = len(predictor.joints)
    guesses = {e.name: first_guesses(e, sizes, n) + read[e.name] for e in effects}
    table = known_candidates(predictor, sections, adopted, effects, guesses, residual)
    table.columns = table.columns[mask]
    screen = Screen(table, residual[mask], data.folds, table.base, table.bounds)
    return screen, table
