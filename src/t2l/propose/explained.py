"""An explanation from end to end, as `t2l explain` and the workflow write it."""

from collections.abc import Sequence
from pathlib import Path

from t2l.diagnose.confounded import Confounded
from t2l.diagnose.evidence import Evidence
from t2l.diagnose.explanation import Explanation, write_explanation
from t2l.diagnose.final_parameters import final_parameters
from t2l.diagnose.forward_selection import explain
from t2l.diagnose.told_apart import told_apart
from t2l.identify.model import Model
from t2l.identify.progress import Progress, part
from t2l.propose.beside import proposed_beside

# format: of the whole, when names are found and curves are learned
NAMED, LEARNED = 0.65, 0.95


def explained(
    model: Model,
    evidence: Evidence,
    folder: Path,
    progress: Progress = lambda what, fraction: None,
    beforehand: Sequence[Confounded] = (),
) -> Explanation:
    """Names, what they leave as curves, and which names have rivals; all of it is written.

    Args:
        evidence: as `t2l.diagnose.ranking.telling` has it.
        folder: receives explanation.json, model.yaml, steps/ and proposal/.
        beforehand: what the recordings cannot tell apart, see `confounded_beforehand`.

    Raises:
        DivergenceError: a simulation of the model runs away.
    """
    naming, learning = part(progress, 0.0, NAMED), part(progress, NAMED, LEARNED)
    explanation = explain(model, evidence, folder, naming, beforehand)
    explanation = proposed_beside(model, explanation, evidence, folder, learning)
    progress("what is not told from the names", LEARNED)
    explanation = told_apart(explanation, model, evidence)
    write_explanation(explanation, folder, final_parameters(model, explanation.model, evidence))
    return explanation
