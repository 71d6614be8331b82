"""Which sets go on: from the screen to fits along the motion, to simulation, and what is taken."""

from collections.abc import Sequence

from t2l.detective.fitted_set import FittedSet
from t2l.detective.rule import Judge
from t2l.detective.screen import Scored, Screen
from t2l.identify.levels import AT_THE_FLOOR, MATERIAL, NOTHING, PROMISING

# numerics: sets of a round that are fitted along the motion: of the front, of each complexity those
# that leave so many times the squared error at most, and of one effect
FRONT, RIVALS, RIVAL, SINGLES = 8, 2, 2.0, 6
EXCHANGES = 24  # numerics: sets that may take the place of terms, that are fitted along the motion
FINISHED = 5  # numerics: sets that are fitted by simulation
LINEAR = 0.01  # numerics: of the squared error that a set explains, what the linear model is off by
BETTER = 0.97  # numerics: of an error, what is less
ASTRAY = 2.0  # numerics: times what the linear model promises, at which a fit by simulation is lost


def worth_fitting(screen: Screen) -> list[Scored]:
    """The front, at each complexity what is nearly as good, and the best single candidates."""
    front = [s for s in screen.search() if s.members]
    known = sorted((s for s in screen.known.values() if s.members), key=lambda s: s.error)
    singles = [s for s in known if len(s.members) == 1]
    rivals = [
        [s for s in known if s.complexity == one.complexity and s.error <= RIVAL * one.error]
        for one in front[:FRONT]
    ]
    chosen: list[Scored] = []
    names: list[set[tuple]] = []

    def take(sets: Sequence[Scored], most: int) -> None:
        for one in sets:
            # of settings the best is enough, of the versions of a curve each says something else
            keys = {(*c.key, len(c.columns)) for c in screen.chosen(one.members)}
            if keys not in names and most > 0:
                chosen.append(one)
                names.append(keys)
                most -= 1

    take(front[:FRONT], FRONT)
    for some in rivals:
        take(some, RIVALS)
    take(singles, SINGLES)
    return chosen


def exchanges(screen: Screen) -> list[Scored]:
    """Sets with others in the place of terms, of one number more at most.

    First those with one effect in the place of one term, the best first. Of the same names only
    the best joints and settings count.
    """
    screen.search()
    least = screen.score(()).error
    alike = [s for s in screen.known.values() if s.members and s.error <= RIVAL * least]
    best: dict[frozenset, Scored] = {}

    def take(sets: Sequence[Scored], most: int) -> None:
        for one in sorted(sets, key=lambda s: s.error):
            if one.complexity <= 1 and len(best) < most:
                names = frozenset((c.removal, c.effect.name) for c in screen.chosen(one.members))
                best.setdefault(names, one)

    take(screen.in_place(), EXCHANGES // 2)
    take(alike, EXCHANGES)
    return [*best.values()]


def leaders(before: FittedSet, fits: Sequence[FittedSet], judge: Judge) -> list[FittedSet]:
    """Of those fitted along the motion what may be taken: the best, the front below it, others.

    The linear model is off by a share of what an effect does, the more for what changes the loop:
    of a simpler set that is nearly as good a simulation tells.
    """
    ranked = sorted(fits, key=lambda f: f.left_out_rmse)
    if not ranked:
        return []
    best = ranked[0].left_out_rmse
    unsure = LINEAR * max(before.left_out_rmse**2 - best**2, 0.0)
    limit = max(PROMISING * best, 2 * judge.noise_rad, (best**2 + unsure) ** 0.5)
    return _simplest_too([f for f in ranked if f.left_out_rmse <= limit])


def _simplest_too(ranked: Sequence[FittedSet]) -> list[FittedSet]:
    """Of some sets, the best first, those that are fitted by simulation: that, and simpler ones."""
    front: list[FittedSet] = []
    for one in sorted(ranked, key=lambda f: (f.complexity, len(f.layout.terms), f.left_out_rmse)):
        if not front or one.left_out_rmse < BETTER * front[-1].left_out_rmse:
            front.append(one)
    kept = {id(f): f for f in (*ranked[:1], *front[:1], *front[::-1], *ranked)}
    return [*kept.values()][:FINISHED]


def exchanged(
    before: FittedSet, fits: Sequence[FittedSet], judge: Judge, most: int
) -> list[FittedSet]:
    """Likewise where only noise is left: what is nearly as good with so many numbers at most.

    Args:
        before: the model along the motion.
    """
    limit = max(PROMISING * before.left_out_rmse, 2 * judge.noise_rad)
    near = [f for f in fits if f.left_out_rmse <= limit and f.complexity <= most]
    return _simplest_too(sorted(near, key=lambda f: f.left_out_rmse))


def nearest(fits: Sequence[FittedSet], judge: Judge) -> list[FittedSet]:
    """Fits of which one may turn out to be the best."""
    if not fits:
        return []
    limit = max(PROMISING * min(f.left_out_rmse for f in fits), 2 * judge.noise_rad)
    return [f for f in fits if f.left_out_rmse <= limit]


def astray(simulated: FittedSet, promised: FittedSet, judge: Judge) -> bool:
    """Whether a fit is far from what the linear model promises: it is lost, not the model."""
    promise = max(promised.left_out_rmse, AT_THE_FLOOR * judge.noise_rad)
    return simulated.left_out_rmse > ASTRAY * promise


def choose(
    current: FittedSet, fits: Sequence[FittedSet], judge: Judge, least: float = MATERIAL
) -> FittedSet | None:
    """The set that the rule takes: of those alike with the best that of fewest numbers.

    Args:
        least: share of the error by which it must fall.
    """
    earning = [f for f in fits if judge.takes(current, f, least)]
    if not earning:
        return None
    best = min(f.left_out_rmse for f in earning)
    alike = [f for f in earning if judge.alike(f.left_out_rmse, best)]
    least_of = min((f.complexity, len(f.layout.terms)) for f in alike)
    fewest = [f for f in alike if (f.complexity, len(f.layout.terms)) == least_of]
    best = min(f.left_out_rmse for f in fewest)
    same = [f for f in fewest if f.left_out_rmse <= (1 + NOTHING) * best]
    return min(same, key=lambda f: (len(f.layout.slots), f.left_out_rmse))
