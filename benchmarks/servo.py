"""A real hobby servo: what t2l finds, beside the friction models of the recordings' makers.

`T2L_STUDY_DATA` names the folder with `xl330_pendulum/`: a Dynamixel XL330 that swings a weight,
three firmware gains, four motions. All but the motion `sin_time_square` are explained, and fitted
by the models M1 to M6 of Duclusaud et al. (2025, arXiv:2410.08650); that one judges. What is made
is kept in results/bench/servo, so that an interrupted run goes on where it stopped.
"""

import json
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from cmaes import CMA

from benchmarks.scene import ROOT
from t2l.artefacts import write_text

FOLDER = ROOT / "results/bench/servo"
TEST = "sin_time_square"
GAINS = (100, 200, 800)
PROCESSES = 2
# of the makers' rig, and their first guess of the motor: N·m/A, Ω
MASS, LENGTH, GRAVITY = 0.49, 0.1, 9.81
TORQUE_CONSTANT, RESISTANCE, SUPPLY_V = 0.304, 2.44, 7.4
DUTY_PER_RAD = 4096 / (2 * np.pi) / (256 * 885)  # of the firmware, for a gain of one
SUBSTEPS = 3  # of a sample of 5.3 ms; twice as many change M6's errors by 0.2 and 2 %
GENERATIONS, POPULATION = 400, 24

# lowest and highest value
MOTOR = {
    "torque_constant": (0.1, 0.8), "resistance": (0.8, 8.0), "armature": (1e-4, 0.02),
    "offset": (-0.1, 0.1), "delay": (0.0, 0.05), "base": (0.0, 0.2), "viscous": (0.0, 0.2),
}  # fmt: skip
STRIBECK = {"stribeck": (0.0, 0.2), "stribeck_speed": (0.02, 3.0), "curvature": (0.5, 5.0)}
SIDES = {
    "by_motor": (0.0, 0.5), "by_load": (0.0, 0.5),
    "by_motor_at_rest": (0.0, 1.0), "by_load_at_rest": (0.0, 1.0),
}  # fmt: skip
MODELS = {
    "M1": {},
    "M2": STRIBECK,
    "M3": {"by_both": (0.0, 0.5)},
    "M4": {**STRIBECK, "by_both": (0.0, 0.5), "by_both_at_rest": (0.0, 1.0)},
    "M5": {**STRIBECK, **SIDES},
    "M6": {**STRIBECK, **SIDES, "motor_squared": (0.0, 5.0), "load_squared": (0.0, 5.0)},
}
GUESS = {
    "torque_constant": TORQUE_CONSTANT, "resistance": RESISTANCE, "armature": 0.0018,
    "offset": 0.0, "delay": 0.005, "base": 0.02, "viscous": 0.005, "stribeck_speed": 0.3,
    "curvature": 1.2,
}  # fmt: skip

MJCF = f"""<mujoco model="xl330">
  <option timestep="0.001"/>
  <worldbody>
    <body>
      <joint name="hinge" type="hinge" axis="0 -1 0" armature="0.0018"/>
      <geom type="sphere" size="0.01" pos="0 0 {-LENGTH}" mass="{MASS}"/>
    </body>
  </worldbody>
  <actuator><motor name="hinge" joint="hinge"/></actuator>
</mujoco>
"""
MAPPING = f"""robot: servo.xml
joints: [hinge]
kp: 1
kd: {TORQUE_CONSTANT**2 / RESISTANCE}
command_rate_hz: 187
control_rate_hz: 1000
gravity_compensation: false
columns:
  time: {{from: time_s, unit: s}}
  q_des: {{from: goal_position_rad, unit: rad}}
  q: {{from: position_rad, unit: rad}}
  dq: {{from: velocity_rad_s, unit: rad/s}}
  supply_voltage: {{from: supply_voltage_V, unit: V}}
  temperature: {{from: temperature_C, unit: °C}}
  torque_enabled: {{from: torque_on}}
"""


@dataclass(frozen=True, eq=False)
class Swing:
    """A recording, columns (n,), and the firmware's gain."""

    gain: int
    table: pd.DataFrame


def run() -> pd.DataFrame:
    """One row a model: RMS errors in mrad where it was fitted and where it is judged."""
    data = os.environ.get("T2L_STUDY_DATA")
    if not data:
        return pd.DataFrame({"skipped": ["T2L_STUDY_DATA does not name the folder of the data"]})
    folder = Path(data) / "xl330_pendulum"
    rows = [{"model": "as it came", **compared(folder, None)}]
    rows.append({"model": "t2l explain", **compared(folder, explained(folder))})
    with ProcessPoolExecutor(PROCESSES) as pool:
        rows += pool.map(fitted, MODELS, [folder] * len(MODELS))
    return pd.DataFrame(rows)


def imported(folder: Path) -> Path:
    """The recordings as t2l reads them, in `fit/` and `test/`."""
    from t2l.cli.main import main

    home = FOLDER / "recordings"
    if not (home / "done").exists():
        write_text(MJCF, home / "servo.xml")
        write_text(MAPPING, home / "mapping.yaml")
        for gain in GAINS:
            kp = DUTY_PER_RAD * gain * SUPPLY_V * TORQUE_CONSTANT / RESISTANCE
            for path in sorted(folder.glob(f"kp{gain}_*.csv")):
                out = home / ("test" if TEST in path.stem else "fit")
                arguments = [str(home / "mapping.yaml"), str(path), "--out", str(out)]
                main(["import-csv", *arguments, "--kp", str(kp)])
        write_text("", home / "done")
    return home


def explained(folder: Path) -> Path:
    """The model that `t2l explain` makes."""
    from t2l.cli.main import main

    out = FOLDER / "explained"
    main(["explain", str(imported(folder) / "fit"), "--out", str(out)])
    return out / "model.yaml"


def compared(folder: Path, model: Path | None) -> dict[str, float]:
    """Errors of a model of t2l, or of the MJCF."""
    from t2l.cli.main import main

    errors = {}
    for part in ("fit", "test"):
        out = FOLDER / f"{part}_{'after' if model else 'before'}"
        given = ["--model", str(model)] if model else []
        main(["compare", str(imported(folder) / part), *given, "--out", str(out)])
        content = json.loads((out / "comparison.json").read_text())
        errors[f"{part}_mrad"] = 1e3 * content["rmse_q_rad"]
    return errors


def fitted(name: str, folder: Path) -> dict:
    """One of the makers' models, fitted by CMA-ES to the mean squared error."""
    path = FOLDER / f"{name}.json"
    if path.exists():
        return json.loads(path.read_text())
    fit, test = swings(folder, False), swings(folder, True)
    names, bounds = zip(*{**MOTOR, **MODELS[name]}.items(), strict=True)
    low, high = np.array(bounds).T
    guess = np.array(
        [GUESS.get(key, low[i] + 0.1 * (high - low)[i]) for i, key in enumerate(names)]
    )
    search = CMA(
        mean=(guess - low) / (high - low), sigma=0.1, bounds=np.tile([0.0, 1.0], (len(names), 1)),
        population_size=POPULATION, seed=1,
    )  # fmt: skip
    best, least = guess, np.inf
    for _ in range(GENERATIONS):
        if search.should_stop():
            break
        asked = [search.ask() for _ in range(POPULATION)]
        values = low + np.array(asked) * (high - low)
        errors = rmse(dict(zip(names, values.T[:, :, None], strict=True)), fit)
        search.tell(list(zip(asked, errors.tolist(), strict=True)))
        if errors.min() < least:
            best, least = values[errors.argmin()], errors.min()
    one = {key: np.array([[value]]) for key, value in zip(names, best, strict=True)}
    result = {
        "model": name, "fit_mrad": 1e3 * float(least), "test_mrad": 1e3 * float(rmse(one, test)[0]),
        **dict(zip(names, best.tolist(), strict=True)),
    }  # fmt: skip
    write_text(json.dumps(result, indent=1), path)
    return result


def swings(folder: Path, test: bool) -> list[Swing]:
    """The recordings that judge, or the others."""
    return [
        Swing(gain, pd.read_csv(path))
        for gain in GAINS
        for path in sorted(folder.glob(f"kp{gain}_*.csv"))
        if (TEST in path.stem) == test
    ]


def rmse(values: dict[str, np.ndarray], recordings: Sequence[Swing]) -> np.ndarray:
    """RMS error in rad of n sets of values (n, 1) over all samples, (n,)."""
    with np.errstate(all="ignore"):
        simulated = simulate(values, recordings)
    squared = [
        (q - swing.table.position_rad.to_numpy()) ** 2
        for q, swing in zip(simulated, recordings, strict=True)
    ]
    return np.nan_to_num(np.sqrt(np.concatenate(squared, axis=1).mean(axis=1)), nan=1e3)


def simulate(values: dict[str, np.ndarray], recordings: Sequence[Swing]) -> list[np.ndarray]:
    """Positions (n, samples) of each recording, all side by side, from its first sample on."""
    n, samples = len(values["offset"]), max(len(r.table) for r in recordings)
    step = np.full((samples, len(recordings)), 1e-3)
    supply, on = np.zeros_like(step), np.zeros(step.shape, bool)
    goal = np.zeros((n, *step.shape))
    for i, recording in enumerate(recordings):
        table, rows = recording.table, slice(len(recording.table))
        time = table.time_s.to_numpy()
        step[: len(table) - 1, i] = np.diff(time)
        supply[rows, i], on[rows, i] = table.supply_voltage_V, table.torque_on > 0
        late = time - values["delay"]
        goal[:, rows, i] = np.interp(late, time, table.goal_position_rad.to_numpy())
    first = np.array([r.table.iloc[0][["position_rad", "velocity_rad_s"]] for r in recordings]).T
    q, dq = np.tile(first[0], (n, 1)) - values["offset"], np.tile(first[1], (n, 1))
    duty_per_rad = DUTY_PER_RAD * np.array([r.gain for r in recordings])
    inertia, kt = MASS * LENGTH**2 + values["armature"], values["torque_constant"]
    out = np.empty((n, *step.shape))
    for k in range(samples):
        out[:, k] = q + values["offset"]
        h = step[k] / SUBSTEPS
        for _ in range(SUBSTEPS):
            duty = np.clip(duty_per_rad * (goal[:, k] - q - values["offset"]), -1, 1)
            motor = np.where(on[k], kt / values["resistance"] * (duty * supply[k] - kt * dq), 0.0)
            load = -MASS * GRAVITY * LENGTH * np.sin(q)
            # as much friction as it takes to stop within the step, at most what there is
            stopping = inertia / h * dq + motor + load
            held = np.minimum(np.abs(stopping), friction(values, motor, load, dq))
            dq = dq + (motor + load - np.sign(stopping) * held) / inertia * h
            q = q + dq * h
    return [out[:, : len(r.table), i] for i, r in enumerate(recordings)]


def friction(
    values: dict[str, np.ndarray], motor: np.ndarray, load: np.ndarray, dq: np.ndarray
) -> np.ndarray:
    """Largest friction in N·m of the model whose values are given (arXiv:2410.08650, sec. III)."""
    level = values["base"] + values["viscous"] * np.abs(dq)
    if "by_both" in values:
        level = level + values["by_both"] * np.abs(motor - load)
    if "by_motor" in values:
        level = level + np.abs(values["by_load"] * load - values["by_motor"] * motor)
    if "stribeck" not in values:
        return level
    at_rest = values["stribeck"]
    if "by_both" in values:
        at_rest = at_rest + values["by_both_at_rest"] * np.abs(motor - load)
    if "by_motor" in values:
        sides = values["by_load_at_rest"] * load - values["by_motor_at_rest"] * motor
        at_rest = at_rest + np.abs(sides)
    if "motor_squared" in values:
        driven = np.abs(load) < np.abs(motor)
        squared = np.where(
            driven, values["load_squared"] * load**2, values["motor_squared"] * motor**2
        )
        at_rest = at_rest + (np.sign(load) != np.sign(motor)) * squared
    slow = np.exp(-((np.abs(dq) / values["stribeck_speed"]) ** values["curvature"]))
    return level + slow * at_rest
