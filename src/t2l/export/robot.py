"""A robot that t2l exported: model.xml, and robot.json with what MJCF has no element of.

    robot = Robot()
    robot.start(q, dq, q_des)        # rad, rad/s, rad, of robot.joints
    while True:
        robot.step(q_des)            # one period of the control loop, robot.period_s
        robot.q, robot.dq

It needs MuJoCo and numpy, not t2l. All names and numbers of the model are in robot.json, which is
read and never executed; functions that it names stand below.
"""

import json
from copy import copy
from pathlib import Path

import mujoco
import numpy as np

FUNCTIONS = {}  # by name, that callbacks call
SETTLINGS = 6  # numerics: times that a load is looked at where the last one bent what lies between


class Robot:
    """The exported robot: MuJoCo steps model.xml, and callbacks add what MJCF has no element of."""

    def __init__(self, model=None):
        path, data = (Path(__file__).with_name(name) for name in ("model.xml", "robot.json"))
        self.model = mujoco.MjModel.from_xml_path(str(path)) if model is None else model
        self.data = mujoco.MjData(self.model)
        self.period_s = self.model.opt.timestep
        own = json.loads(data.read_text(encoding="utf-8"))
        self.joints = own["joints"]
        self.encoder_offset = np.array(own["encoder_offset"])  # rad, measured minus true
        # N·m of the actuators' torque that act on the joints themselves
        self.constant = np.array(own["constant"])
        # joint, other joint of the model, share of the latter's position that the encoder adds
        self.read_too = own["read_too"]
        # gravity, and (mass, its place) of links, that gravity compensation goes by if not the
        # model's
        self.compensated_links = own["compensated"]
        # what runs before each timestep: function, joints, values
        self.callbacks = [
            (FUNCTIONS[call["function"]], np.array(call["joints"], int), _arrays(call["values"]))
            for call in own["callbacks"]
        ]
        # of these, by the signal that they change, those that remember nothing
        self.stateless = {"controller": [], "motor": [], "joint": []}
        for call, one in zip(own["callbacks"], self.callbacks, strict=True):
            if call["stateless"]:
                self.stateless[call["on"]].append(one)
        joints = [self.model.joint(name) for name in self.joints]
        self.ids = np.array([joint.id for joint in joints])
        self.qadr = np.array([joint.qposadr[0] for joint in joints])
        self.dofs = np.array([joint.dofadr[0] for joint in joints])
        self.actuators = np.array([self.model.actuator(name).id for name in self.joints])
        # which positions and velocities an encoder adds up
        self.reads = np.zeros((len(self.joints), self.model.nv))
        self.reads[np.arange(len(self.joints)), self.dofs] = 1.0
        for i, name, share in self.read_too:
            self.reads[i, self.model.joint(name).dofadr[0]] = share
        if self.compensated_links:
            self.compensated = copy(self.model)
            self.compensated.opt.gravity, links = self.compensated_links
            for name, (mass, place) in links.items():
                body = self.compensated.body(name)
                body.mass, body.ipos = mass, place
            self.compensation = mujoco.MjData(self.compensated)
        # friction that callbacks add to: of a joint, or of an element beside the joint's own
        kind = mujoco.mjtObj.mjOBJ_TENDON
        found = [mujoco.mj_name2id(self.model, kind, f"{name}/friction") for name in self.joints]
        self.elements = [
            (self.model.dof_frictionloss, dof)
            if tendon < 0
            else (self.model.tendon_frictionloss, tendon)
            for dof, tendon in zip(self.dofs, found, strict=True)
        ]
        # what callbacks change for one step
        self.fields = [
            self.model.jnt_stiffness,
            self.model.qpos_spring,
            self.model.dof_damping,
            self.model.dof_frictionloss,
            self.model.tendon_frictionloss,
        ]

    def start(self, q, dq, q_des):
        """Begin at measured positions and velocities, under a command that holds since long."""
        data, model = self.data, self.model
        mujoco.mj_resetData(model, data)
        self.tick, self.states = 0, [{} for _ in self.callbacks]
        # MuJoCo's positions are half a step of velocity ahead of the loop's
        ahead = np.asarray(q) + 0.5 * self.period_s * np.asarray(dq)
        data.qpos[self.qadr] = ahead
        data.qvel[self.dofs], data.ctrl[:] = dq, q_des
        self.last_velocity = data.qvel[self.dofs]
        # what is between motor and link starts at rest under its load, which changes as it bends
        between = [joint for joint in range(model.njnt) if joint not in self.ids]
        for _ in range(SETTLINGS if between else 1):
            mujoco.mj_forward(model, data)
            for joint in between:
                data.qpos[model.jnt_qposadr[joint]] = self._bent(joint)
            data.qpos[self.qadr] = ahead - (self._reading(data.qpos) - data.qpos[self.qadr])
        for name in self.joints:
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
        data, own = self.data, [field.copy() for field in self.fields]
        data.ctrl[:] = q_des
        if self.callbacks or self.read_too or self.compensated_links:
            mujoco.mj_step1(self.model, data)
            mujoco.mj_fwdActuation(self.model, data)
            given = data.qfrc_actuator[self.dofs]
            self._signals(given)
            for i, (function, joints, values) in enumerate(self.callbacks):
                self.state = self.states[i]
                function(self, joints, values)
            self._apply(given)
        mujoco.mj_step(self.model, data)
        for field, values in zip(self.fields, own, strict=True):
            field[:] = values
        self.tick += 1

    @property
    def q(self):
        """Measured positions, rad."""
        return self._reading(self.data.qpos) - 0.5 * self.period_s * self.dq

    @property
    def dq(self):
        """Measured velocities, rad/s."""
        return self._reading(self.data.qvel)

    def torques_at_rest(self):
        """N·m on joints that rest, of what remembers nothing."""
        return self._at_rest("joint", self.motor)[1]

    def given_at_rest(self, demand):
        """What motors that remember nothing make there of a demand, N·m."""
        return self._at_rest("motor", demand.copy())[0]

    def _at_rest(self, signal, motor):
        names = "motor", "torque", "friction", "stiffness", "pull", "damping", "rate", "velocity"
        before = {name: getattr(self, name).copy() for name in names}
        self.motor, (self.rate, self.velocity) = motor, np.zeros((2, len(self.joints)))
        for function, joints, values in self.stateless[signal]:
            function(self, joints, values)
        found = self.motor, self.torque
        for name, values in before.items():
            setattr(self, name, values)
        return found

    def _reading(self, values):
        return self.reads @ values

    def _bent(self, joint):
        """Where a joint between motor and link rests, rad."""
        model, dof = self.model, self.model.jnt_dofadr[joint]
        load = self.data.qfrc_bias[dof]
        if model.jnt_stiffness[joint] > 0:
            return -load / model.jnt_stiffness[joint]
        if not model.jnt_limited[joint]:
            return self.data.qpos[model.jnt_qposadr[joint]]
        # play: its teeth bear the load as a spring of this compliance does
        compliance = model.dof_invweight0[dof] / -model.jnt_solref[joint, 0]
        return -np.sign(load) * model.jnt_range[joint, 1] - compliance * load

    def _signals(self, given):
        """What callbacks see; `given` is what the actuators give, N·m."""
        data, model, at = self.data, self.model, self.actuators
        # in the middle of the step, for which the torque is held
        self.angle = data.qpos[self.qadr] - self.encoder_offset
        self.load = data.qfrc_bias[self.dofs]
        self.gravity = data.qfrc_gravcomp[self.dofs]
        self.passive = data.qfrc_passive[self.dofs]
        # at the tick of the loop
        self.velocity = data.qvel[self.dofs]
        self.position = data.qpos[self.qadr] - 0.5 * self.period_s * self.velocity
        self.rate = self.velocity + 0.5 * (self.velocity - self.last_velocity)
        self.last_velocity = self.velocity
        self.kp = model.actuator_gainprm[at, 0]
        self.kd = 0.5 * self.period_s * self.kp - model.actuator_biasprm[at, 2]
        # the command after delay and filter, of which MuJoCo tells the force alone
        constant, by_position, by_velocity = model.actuator_biasprm[at, :3].T
        biased = constant + by_position * data.qpos[self.qadr] + by_velocity * self.velocity
        self.target = data.ctrl[at].copy()
        np.divide(data.actuator_force[at] - biased, self.kp, out=self.target, where=self.kp != 0)
        # actuators read the position of the motor, encoders perhaps that of the link
        elsewhere = self.kp * (self.q - self.position) + self.kd * (self.dq - self.velocity)
        self.motor = given - self.constant - elsewhere
        if self.compensated_links:
            self.compensation.qpos = data.qpos - 0.5 * self.period_s * data.qvel
            mujoco.mj_step1(self.compensated, self.compensation)
            self.motor += self.compensation.qfrc_gravcomp[self.dofs] - self.gravity
        self.torque = self.constant.copy()
        self.friction = np.array([field[i] for field, i in self.elements])
        self.stiffness, self.pull, self.damping = np.zeros((3, len(self.joints)))

    def _apply(self, given):
        """Write what callbacks have changed into data and model."""
        data, model = self.data, self.model
        data.qfrc_applied[self.dofs] = self.motor + self.torque - given
        for (field, i), level in zip(self.elements, self.friction, strict=True):
            field[i] = max(level, 0.0)
        pull = self.pull + model.jnt_stiffness[self.ids] * model.qpos_spring[self.qadr]
        model.jnt_stiffness[self.ids] += self.stiffness
        model.qpos_spring[self.qadr] = pull / np.maximum(model.jnt_stiffness[self.ids], 1e-12)
        model.dof_damping[self.dofs] += self.damping


def _arrays(values):
    """Lists of JSON as arrays."""
    if isinstance(values, dict):
        return {name: _arrays(value) for name, value in values.items()}
    return np.array(values) if isinstance(values, list) else values
