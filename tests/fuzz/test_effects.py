"""Effect files that a person wrote and got wrong, under `t2l diagnose`'s own steps."""

import pytest

from t2l.detective.data_split import split
from t2l.detective.ranking import diagnose
from t2l.effects.registry import load
from t2l.errors import T2LError
from t2l.identify.model import Model
from tests.diagnose.made import all_but, pendulum, swings
from tests.effects.test_registry import RUBBER
from tests.fuzz.harness import check

INSTALL = 'torque[rows, joints] -= values["stiffness"] * q[rows, joints]'
STARTS = 'return [{"stiffness": factor * scales.kp} for factor in (0.01, 0.1)]'
CLASS = "class Rubber(Effect):"

TUPLE = '(Parameter("stiffness", "N·m/rad", 0.0, 100.0, "of the cord"),)'
IMPORT = "import Effect, Parameter"
FOREIGN = CLASS.replace("class", "import nowhere_to_be_found\n\n\nclass")

# what is replaced in a sound effect, and a word of the message
WRONG = {
    "exits on import": (IMPORT, f"{IMPORT}; exit()", "SystemExit"),
    "cannot be imported": (CLASS, FOREIGN, "nowhere_to_be_found"),
    "is no Python": (CLASS, "class Rubber(Effect:", "cannot be imported"),
    "name of a path": ('name = "rubber"', 'name = "../../../evil"', "name: found '../../../evil'"),
    "name is no text": ('name = "rubber"', "name = 3", "name: found 3"),
    "title is no text": ('title = "rubber cord"', "title = None", "title: found nothing"),
    "name of another": ('name = "rubber"', 'name = "armature"', "named 'armature'"),
    "no parameters": (TUPLE, "()", r"parameters: found \(\)"),
    "parameters of another kind": (TUPLE, '("stiffness",)', "a tuple of `Parameter`"),
    "bounds the wrong way": ("0.0, 100.0", "100.0, 0.0", "lower, upper: found 100.0, 0.0"),
    "bounds that are none": ("0.0, 100.0", 'float("nan"), 100.0', "lower: found nan"),
    "bounds of text": ("0.0, 100.0", '"0", 100.0', "lower: found '0'"),
    "unit that is none": ('"N·m/rad"', "None", "unit: found nothing"),
    "cannot be made": ("    name = ", "    def __init__(self):\n        1 / 0\n\n    name = ",
                       "cannot be made"),
    "raises in install": (INSTALL, "raise ValueError('no cord')", r"line \d+.*no cord"),
    "exits in install": ("loop.joint_torques.append(add)", "exit(3)", r"line \d+.*SystemExit: 3"),
    "wrong shape": (INSTALL, "torque[rows, joints] -= [1, 2, 3]", r"rubber.py, line \d+"),
    "installs what cannot be called": ("append(add)", "append(3)", "rubber.*not callable"),
    "torque that is no number": (
        INSTALL, "torque[rows, joints] = float('nan')", "no finite motion"
    ),
    "starts raises": (STARTS, "return scales.nothing", r"rubber.py, line \d+.*no attribute"),
    "starts returns nothing": (STARTS, "return None", "rubber.*first guesses"),
    "starts returns none": (STARTS, "return []", "rubber.*at least one"),
    "starts lacks a parameter": (STARTS, "return [{}]", "rubber.*for stiffness"),
    "starts is no number": (STARTS, 'return [{"stiffness": float("nan")}]', "rubber.*finite"),
    "starts has another shape": (STARTS, 'return [{"stiffness": [1, 2, 3]}]', "rubber.*broadcast"),
    "extend raises": ("    def install", "    def extend(self, spec, joints):\n        1 / 0\n\n"
                      "    def install", r"line \d+.*extend.*division"),
    "extend breaks the model": ("    def install", "    def extend(self, spec, joints):\n"
                                "        spec.worldbody.add_body(name='b').add_joint()\n\n"
                                "    def install", "with rubber: MuJoCo cannot compile"),
    "read_off raises": ("    def install", "    def read_off(self, q, torque, clock_s):\n"
                        "        1 / 0\n\n"
                        "    def install", "read_off.*division"),
    "read_off is no number": ("    def install", "    def read_off(self, q, torque, clock_s):\n"
                              "        return {'stiffness': None}\n\n    def install", "read_off"),
}  # fmt: skip


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    robot = pendulum(tmp_path_factory.mktemp("robot"))
    return robot, swings(robot, {}, duration_s=0.3, control_rate_hz=125.0)


def try_out(robot, recordings, path):
    """The effect of a file, loaded and fitted for the first time."""
    load([path])
    model = Model(robot, {}, (path,), without=all_but())
    return diagnose(model, split(robot, recordings, threads=1))


def test_the_sound_one_runs(recorded, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.dont_write_bytecode", False)
    path = tmp_path / "rubber.py"
    path.write_text(RUBBER)
    assert check(lambda: try_out(*recorded, path), tmp_path, tmp_path / "out") is None


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_is_told_with_effect_and_file(recorded, tmp_path, kind):
    old, new, said = WRONG[kind]
    assert RUBBER.count(old) == 1
    path = tmp_path / "rubber.py"
    path.write_text(RUBBER.replace(old, new))
    with pytest.raises(T2LError, match=f"(?s){said}") as caught:
        try_out(*recorded, path)
    assert "rubber" in str(caught.value)


def test_an_effect_of_t2ls_own_that_cannot_run_does_not_stop_the_others(recorded, monkeypatch):
    robot, recordings = recorded
    effects = load()

    class Wild(type(effects["viscous_friction"])):
        def install(self, loop, rows, joints, values):
            loop.batch.qpos[rows] = float("nan")
            loop.settle.append(lambda loop: loop.batch.qpos.fill(float("nan")))

    Wild.__module__ = "t2l.effects.wild"
    few = {"viscous_friction": Wild(), "armature": effects["armature"]}
    monkeypatch.setattr("t2l.identify.model.load_effects", lambda files: few)
    found = diagnose(Model(robot), split(robot, recordings, threads=1))
    assert [c.effect.name for c in found.ranking] == ["armature"]
