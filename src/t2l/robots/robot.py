"""What the rest of t2l needs to know of a robot, besides its MJCF."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Robot:
    """Names and limits of a position-controlled arm with a gripper.

    Attributes:
        joints: arm joints, each driven by the actuator of the same name.
        torque_limit: N·m, one per joint.
        home: rad, one per joint, the pose that starts are sampled around.
        grip_site: site between the fingertips, z along the approach direction.
        gripper_joints: finger slides that move as one, each with an actuator of its name.
        gripper_open: m, finger position when fully open.
    """

    name: str
    joints: tuple[str, ...]
    torque_limit: tuple[float, ...]
    home: tuple[float, ...]
    grip_site: str
    gripper_joints: tuple[str, ...]
    gripper_open: float
