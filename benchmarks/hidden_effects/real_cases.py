"""Cases of `real_effects`: two sizes of each, on a pendulum or a two-joint arm."""

from benchmarks.hidden_effects.effects import CoulombFriction, Payload
from benchmarks.hidden_effects.real_effects import (
    BaseTilt,
    ClockOffset,
    DahlFriction,
    DirectionalFriction,
    FrictionDrift,
    FrictionTemperature,
    IntegralAction,
    JointCoupling,
    LinkInertia,
    LugreFriction,
    ParallelSpring,
    PeriodicTorque,
    TorqueConstantDrift,
    TorqueConstantTemperature,
    TorqueSpeedLimit,
    VelocityFilter,
)

PENDULUM, ARM = "pendulum", "two_joint_arm"
BARE, RUBBING = "bare_pendulum", "rubbing_pendulum"
HANGING = {"gravity_compensation": False}
BALANCED = {"gravity_compensation": "continuous"}


def elbow(stiffness, ratio, rest, damping=0.0):
    """A cable along both joints of the arm."""
    return JointCoupling("elbow", "shoulder", stiffness, ratio, rest, damping)


def bristles(coulomb, static, velocity, presliding, damping):
    """LuGre friction by its breakaway deflection [rad] and σ1 [N·m·s/rad]."""
    return LugreFriction(coulomb, static, velocity, static / presliding, damping)


# name of the effect, robot, effect, changes of the setup
REAL = (
    ("parallel_spring", PENDULUM, ParallelSpring(0.05, 0.6), {}),
    ("parallel_spring", PENDULUM, ParallelSpring(0.6, 0.2), {}),
    ("parallel_spring", ARM, ParallelSpring({"elbow": 0.3}, 1.2), {}),
    ("base_tilt", PENDULUM, BaseTilt(0.0, 0.03), {}),
    ("base_tilt", PENDULUM, BaseTilt(0.0, -0.2), {}),
    ("base_tilt", ARM, BaseTilt(0.05, 0.1), {}),
    ("base_tilt", ARM, BaseTilt(0.0, 0.1), BALANCED),
    ("link_inertia", PENDULUM, LinkInertia("bar", 1.1), {}),
    ("link_inertia", PENDULUM, LinkInertia("bar", 1.5, (0.02, 0.0, -0.01), 1.3), {}),
    ("link_inertia", ARM, LinkInertia("upper_arm", 1.3, (0.0, 0.0, -0.03)), {}),
    ("link_inertia", ARM, LinkInertia("forearm", 0.7, (0.01, 0.0, 0.03), 1.2), HANGING),
    ("payload", BARE, Payload(0.05, site="bob"), {}),
    ("payload", BARE, Payload(0.3, com=(0.02, 0.0, -0.05), site="bob"), {}),
    ("coulomb_friction", RUBBING, CoulombFriction(0.05), {}),
    ("coulomb_friction", RUBBING, CoulombFriction(0.25), {}),
    ("integral_action", PENDULUM, IntegralAction(1.0, 2.0), {}),
    ("integral_action", PENDULUM, IntegralAction(15.0, 0.4), {}),
    ("integral_action", ARM, IntegralAction(8.0, 1.5), HANGING),
    ("velocity_filter", PENDULUM, VelocityFilter(40.0), {}),
    ("velocity_filter", PENDULUM, VelocityFilter(8.0), {}),
    ("joint_coupling", ARM, elbow(0.15, 0.5, 0.9), {}),
    ("joint_coupling", ARM, elbow(1.0, -0.8, 0.3, 0.02), {}),
    ("dahl_friction", PENDULUM, DahlFriction(0.03, 0.004), {}),
    ("dahl_friction", PENDULUM, DahlFriction(0.15, 0.03), {}),
    ("dahl_friction", ARM, DahlFriction({"shoulder": 0.2, "elbow": 0.08}, 0.01), {}),
    ("lugre_friction", PENDULUM, bristles(0.02, 0.04, 0.1, 0.003, 0.05), {}),
    ("lugre_friction", PENDULUM, bristles(0.06, 0.14, 0.15, 0.008, 0.2), {}),
    ("directional_friction", PENDULUM, DirectionalFriction(0.04, 0.02), {}),
    ("directional_friction", PENDULUM, DirectionalFriction(0.05, 0.2), {}),
    ("torque_speed_limit", PENDULUM, TorqueSpeedLimit(2.0, 15.0), {}),
    ("torque_speed_limit", PENDULUM, TorqueSpeedLimit(1.6, 8.0, 12.6, 0.1), {}),
    ("periodic_torque", PENDULUM, PeriodicTorque(0.008, 1.3, 0.4), {}),
    ("periodic_torque", ARM, PeriodicTorque({"elbow": 0.08}, 0.73), {}),
    ("friction_drift", PENDULUM, FrictionDrift(0.08, 0.02, 10.0), {}),
    ("friction_drift", ARM, FrictionDrift({"elbow": 0.02}, {"elbow": 0.1}, 15.0), {}),
    ("torque_constant_drift", PENDULUM, TorqueConstantDrift(1.0, 0.85, 15.0), {}),
    ("torque_constant_drift", ARM, TorqueConstantDrift(1.05, 0.7, 20.0), HANGING),
    ("friction_temperature", PENDULUM, FrictionTemperature(level=0.06, per_kelvin=-1e-3), {}),
    ("friction_temperature", ARM, FrictionTemperature(level=0.05, per_kelvin=2e-3), {}),
    ("torque_constant_temperature", PENDULUM, TorqueConstantTemperature(per_kelvin=-2e-3), {}),
    (
        "torque_constant_temperature",
        PENDULUM,
        TorqueConstantTemperature(rise_k=60.0, per_kelvin=-6e-3),
        {},
    ),
    ("clock_offset", PENDULUM, ClockOffset(0.003), {}),
    ("clock_offset", ARM, ClockOffset(0.02), {}),
)
CLEAN = (("rubbing_pendulum", RUBBING, {}),)
