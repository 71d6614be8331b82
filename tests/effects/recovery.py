"""Planted parameters, found again by t2l's own fitting."""

import numpy as np

from t2l.effects.effect import Effect, within
from t2l.effects.registry import builtin
from t2l.effects.term import Layout, Term
from t2l.identify.fitting import run, start_from_the_best
from t2l.identify.least_squares import LeastSquares
from t2l.identify.prediction import Predictor
from t2l.identify.scales import scales
from tests.diagnose.made import read

ITERATIONS = 15


def recovered(name, recordings, joints=None):
    """``{parameter: (k,)}`` of effect `name` on `joints`, and the RMS error of the fit in rad."""
    predictor = Predictor(recordings[0].robot, recordings, threads=1)
    sizes = scales(predictor)
    effect = within(builtin()[name], predictor.model(), predictor.joints, sizes)
    joints = joints or tuple(range(len(predictor.joints)))
    layout, mask = Layout([Term(effect, joints)]), np.ones(len(predictor.samples), bool)
    starts = _starts(effect, predictor, joints, sizes)
    u = np.array([layout.encode({name: start}) for start in starts])
    sizes = [max(np.abs(np.median(u[:, i])), s.size, 1e-3 * s.scale)
             for i, s in enumerate(layout.slots)]  # fmt: skip
    fit = LeastSquares(layout, u[0], np.array(sizes))
    start_from_the_best({name: fit}, {name: u}, predictor, mask)
    run([fit], predictor, mask, ITERATIONS)
    return {p: v[0] for p, v in layout.decode(fit.u[None])[name].items()}, np.sqrt(fit.loss)


def _starts(effect, predictor, joints, sizes):
    starts = [
        {p.name: np.asarray(start[p.name])[list(joints)] if p.per_joint else start[p.name]
         for p in effect.parameters}
        for start in effect.starts(sizes)
    ]  # fmt: skip
    if type(effect).read_off is Effect.read_off:
        return starts
    found = read(predictor, (Layout(()), np.zeros(0)), [effect])[effect.name]
    return [*starts, *({name: of[list(joints)] for name, of in one.items()} for one in found)]
