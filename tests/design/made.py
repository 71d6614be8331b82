"""A pendulum, and a virtual one with physics of its own, as a user would write them."""

from pathlib import Path

import yaml

from tests.conftest import ROOT
from tests.diagnose.made import pendulum

COULOMB = 0.05
# a pendulum with hardly more than dry friction
PHYSICS = {
    "coulomb": COULOMB, "breakaway_ratio": 1.0, "viscous": 0.02, "torque_offset": 0.0,
    "gear_stiffness": 2000.0, "gear_damping_ratio": 1.0, "torque_bandwidth_hz": 1000,
    "command_latency_s": 0.0, "velocity_noise_rad_s": 0.0, "velocity_cutoff_hz": 400,
    "position_noise_rad": 1.0e-4, "torque_limit": 20.0,
}  # fmt: skip
LIMITS = {"velocity_rad_s": 5.0, "torque_nm": 4.0}


def configuration(folder: Path, **changes) -> Path:
    """A configuration of recordings without motions, of a robot that is only a file."""
    pendulum(folder)
    physics = yaml.safe_load((ROOT / "src/t2l/hardware/virtual_fr3.yaml").read_text())
    for key, entry in physics.items():
        entry["value"] = PHYSICS.get(key, entry["value"])
        if isinstance(entry["value"], list):
            entry["value"] = entry["value"][-1]
    (folder / "physics.yaml").write_text(yaml.safe_dump(physics))
    written = {
        "backend": "virtual", "physics": str(folder / "physics.yaml"), "robot": "pendulum.xml",
        "limits": LIMITS, "gains": {"kp": 20, "kd": 0.8}, **changes,
    }  # fmt: skip
    path = folder / "setup.yaml"
    path.write_text(yaml.safe_dump({k: v for k, v in written.items() if v is not None}))
    return path
