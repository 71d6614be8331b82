"""The text of robot.py, which stands beside an exported MJCF and needs MuJoCo and numpy only."""

from t2l.effects.exported import Exported

HEAD = '''"""{title}

    robot = Robot()
    robot.start(q, dq, q_des)        # rad, rad/s, rad: {count} joints
    while True:
        robot.step(q_des)            # one period of the control loop, {period:g} s
        robot.q, robot.dq

Written by t2l export. It needs MuJoCo and numpy, not t2l.
{lost}"""

from pathlib import Path

import mujoco
import numpy as np

JOINTS = {joints!r}
ENCODER_OFFSET = np.array({offset})  # rad, measured minus true
# what runs before each timestep: function, joints, values
CALLBACKS = {callbacks}


class Robot:
    """The exported robot: MuJoCo steps model.xml, and callbacks add what MJCF has no element of."""

    def __init__(self, model=None):
        path = Path(__file__).with_name("model.xml")
        self.model = mujoco.MjModel.from_xml_path(str(path)) if model is None else model
        self.data = mujoco.MjData(self.model)
        self.period_s = self.model.opt.timestep
        ids = [self.model.joint(name) for name in JOINTS]
        self.qadr = np.array([joint.qposadr[0] for joint in ids])
        self.dofs = np.array([joint.dofadr[0] for joint in ids])
        # friction that callbacks add to: of a joint, or of an element beside the joint's own
        kind = mujoco.mjtObj.mjOBJ_TENDON
        found = [mujoco.mj_name2id(self.model, kind, f"{{name}}/friction") for name in JOINTS]
        self.elements = [
            (self.model.dof_frictionloss, dof)
            if tendon < 0
            else (self.model.tendon_frictionloss, tendon)
            for dof, tendon in zip(self.dofs, found)
        ]
        self.constant_friction = np.array([field[i] for field, i in self.elements])

    def start(self, q, dq, q_des):
        """Begin at measured positions and velocities, under a command that holds since long."""
        data, model = self.data, self.model
        mujoco.mj_resetData(model, data)
        # MuJoCo's positions are half a step of velocity ahead of the loop's
        data.qpos[self.qadr] = np.asarray(q) + 0.5 * self.period_s * np.asarray(dq)
        data.qvel[self.dofs], data.ctrl[:] = dq, q_des
        # a spring between motor and link starts at rest under its load
        mujoco.mj_forward(model, data)
        for joint in range(model.njnt):
            dof, adr = model.jnt_dofadr[joint], model.jnt_qposadr[joint]
            if dof not in self.dofs and model.jnt_stiffness[joint] > 0:
                data.qpos[adr] = -data.qfrc_bias[dof] / model.jnt_stiffness[joint]
        for i, name in enumerate(JOINTS):
            actuator = model.actuator(name)
            if actuator.actadr[0] >= 0:
                data.act[actuator.actadr[0]] = data.ctrl[actuator.id]
            if model.actuator_delay[actuator.id] > 0:
                count = int(model.actuator_history[actuator.id, 0])
                times = self.period_s * np.arange(-count, 0.0).reshape(-1, 1)
                values = np.full((count, 1), data.ctrl[actuator.id])
                mujoco.mj_initCtrlHistory(model, data, actuator.id, times, values)

    def step(self, q_des):
        """Advance by one period of the control loop under a command."""
        data, model = self.data, self.model
        data.ctrl[:] = q_des
        if CALLBACKS:
            mujoco.mj_step1(model, data)
            mujoco.mj_fwdActuation(model, data)
            # in the middle of the step, for which the torque is held
            self.angle = data.qpos[self.qadr] - ENCODER_OFFSET
            self.motor = data.qfrc_actuator[self.dofs]
            self.load = data.qfrc_bias[self.dofs]
            self.gravity = data.qfrc_gravcomp[self.dofs]
            self.torque, self.friction = np.zeros(len(JOINTS)), self.constant_friction.copy()
            for function, joints, values in CALLBACKS:
                function(self, joints, values)
            data.qfrc_applied[self.dofs] = self.torque
            for (field, i), level in zip(self.elements, self.friction):
                field[i] = max(level, 0.0)
        mujoco.mj_step(model, data)

    @property
    def q(self):
        """Measured positions, rad."""
        return self.data.qpos[self.qadr] - 0.5 * self.period_s * self.data.qvel[self.dofs]

    @property
    def dq(self):
        """Velocities, rad/s."""
        return self.data.qvel[self.dofs].copy()
'''


def robot_text(to: Exported, title: str) -> str:
    """robot.py of an exported robot."""
    calls = ",\n".join(
        f"    ({call.function.__name__}, np.array({list(call.joints)}), {_literal(call.values)})"
        for call in to.callbacks
    )
    sources = {call.function.__name__: call.source for call in to.callbacks}
    lost = "".join(f"\nNot carried: {effect} ({why})." for effect, why in to.lost)
    head = HEAD.format(
        title=title,
        count=len(to.joints),
        period=to.period_s,
        joints=list(to.joints),
        offset=to.encoder_offset.tolist(),
        callbacks="[]" if not to.callbacks else "None  # below",
        lost=f"{lost}\n" if lost else "",
    )
    if not to.callbacks:
        return head
    functions = "\n\n".join(sources.values())
    return f"{head}\n\n{functions}\n\nCALLBACKS = [\n{calls},\n]\n"


def _literal(values) -> str:
    parts = (
        f'"{name}": {f"np.array({value.tolist()})" if hasattr(value, "tolist") else repr(value)}'
        for name, value in values.items()
    )
    return "{" + ", ".join(parts) + "}"
