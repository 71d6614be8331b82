"""The example that ships with the project: `python -m benchmarks.hidden_effects.example`.

A small arm whose elbow rubs and whose commands arrive late, which its MJCF does not know.
"""

from benchmarks.hidden_effects.cases import Case, make
from benchmarks.hidden_effects.effects import CommandDelay, CoulombFriction
from benchmarks.scene import ROOT

EXAMPLE = Case(
    name="two_joint_arm",
    robot="two_joint_arm",
    hidden=(CoulombFriction({"elbow": 0.05}), CommandDelay(0.012)),
    seed=7,
    changes={"duration_s": 3.0, "sample_rate_hz": 100},
)

if __name__ == "__main__":
    make(EXAMPLE, ROOT / "examples" / EXAMPLE.name)
