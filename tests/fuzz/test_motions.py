"""Whatever gains and motions a virtual robot is given, it is not measured beyond its limits."""

import shutil

import numpy as np
import pytest
import yaml
from hypothesis import event, given, settings
from hypothesis import strategies as st

from t2l.cli.main import main
from t2l.hardware.plan import read_plan
from t2l.hardware.virtual import VirtualRobot
from tests.design.made import configuration
from tests.fuzz.harness import check
from tests.fuzz.test_recordings import QUIET


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    home = tmp_path_factory.mktemp("home")
    configuration(home)
    return home


def sizes(low, high):
    """Numbers of any size between two, each decade alike."""
    return st.floats(np.log10(low), np.log10(high)).map(lambda x: float(f"{10**x:.3g}"))


EXCITATIONS = st.one_of(
    st.fixed_dictionaries({"kind": st.just("sine"), "frequency_hz": sizes(0.1, 12)}),
    st.fixed_dictionaries(
        {"kind": st.just("point_to_point"), "move_s": sizes(0.02, 1), "dwell_s": sizes(0.02, 1)}
    ),
    st.fixed_dictionaries({"kind": st.just("triangle"), "frequency_hz": sizes(0.1, 5)}),
    st.fixed_dictionaries({"kind": st.just("hold"), "ramp_s": sizes(0.01, 0.5)}),
)
MACHINES = {
    "as it is": {}, "slow": {"torque_bandwidth_hz": 2.0}, "late": {"command_latency_s": 0.1},
    "smooth": {"coulomb": 0.0, "viscous": 0.0}, "offset": {"torque_offset": 3.0},
    "filtered": {"velocity_cutoff_hz": 3.0},
}  # fmt: skip


@pytest.fixture
def beyond(monkeypatch):
    """What a virtual robot measured beyond a limit, at whichever of its ticks."""
    found = []
    tick = VirtualRobot._tick

    def noted(self, q_des):
        tick(self, q_des)
        low, high = self.robot.position_limit.T
        kept = (
            (self._q >= low) & (self._q <= high)
            & (np.abs(self._dq) <= self.robot.velocity_limit)
            & (np.abs(self._torque) <= self.robot.torque_limit)
        )  # fmt: skip
        if not kept.all():
            found.append((self._q, self._dq, self._torque))

    monkeypatch.setattr(VirtualRobot, "_tick", noted)
    return found


@settings(max_examples=25, **QUIET)
@given(data=st.data())
def test_what_ends_well_was_never_beyond_a_limit(home, beyond, data):
    written = yaml.safe_load((home / "setup.yaml").read_text())
    physics = yaml.safe_load((home / "physics.yaml").read_text())
    for key, value in MACHINES[data.draw(st.sampled_from(sorted(MACHINES)))].items():
        physics[key]["value"] = value
    (home / "machine.yaml").write_text(yaml.safe_dump(physics))
    written["physics"] = str(home / "machine.yaml")
    written["gains"] = {"kp": data.draw(sizes(1, 300)), "kd": data.draw(sizes(1e-3, 100))}
    written["command_rate_hz"] = data.draw(st.sampled_from([50, 50, 10, 200]))
    excitation = data.draw(EXCITATIONS)
    excitation |= {"amplitude_rad": data.draw(sizes(0.003, 0.6)), "duration_s": 1}
    written["excitation"] = excitation
    (home / "plan.yaml").write_text(yaml.safe_dump(written))
    beyond.clear()
    message = check(
        lambda: main(["record", "plan.yaml", "--out", "out"]), home, home / "out", ("plan.yaml",)
    )
    assert (home / "out").exists() == (message is None)
    shutil.rmtree(home / "out", ignore_errors=True)
    # the first that is beyond is the last that is made
    stopped = message is not None and "the robot was stopped: found" in message
    assert len(beyond) == stopped
    event("stopped" if stopped else "refused" if message else "ran")


def test_a_sound_one_runs(home):
    sine = {"kind": "sine", "amplitude_rad": 0.1, "duration_s": 1, "frequency_hz": 1}
    written = yaml.safe_load((home / "setup.yaml").read_text()) | {"excitation": sine}
    (home / "plan.yaml").write_text(yaml.safe_dump(written))
    assert read_plan(home / "plan.yaml").motions
    assert check(lambda: main(["record", "plan.yaml", "--out", "out"]), home, home / "out") is None
    shutil.rmtree(home / "out")
