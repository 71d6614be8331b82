"""Of an explanation's names, which cannot be told from other effects."""

from dataclasses import replace

from t2l.diagnose.confounded import sentences
from t2l.diagnose.confounding import confounded_names
from t2l.diagnose.evidence import Evidence, deciding
from t2l.diagnose.explanation import Explanation
from t2l.identify.model import Model


def told_apart(explanation: Explanation, came: Model, evidence: Evidence) -> Explanation:
    """The explanation, and in its sentence which names cannot be told from other effects.

    Args:
        came: the model as it came.
    """
    found = confounded_names(explanation.names, came, evidence)
    if not found:
        return explanation
    said = sentences(found, came.known_effects(), deciding(evidence)[0].recordings)
    sentence = " ".join([explanation.sentence, *said])
    return replace(explanation, confounded=tuple(found), sentence=sentence)
