"""Inverse dynamics of the bodies of a model, at many places at once.

They are linear in the inertial parameters of each body: τ = Σ Y_b π_b. π_b is the mass, the mass
times the position of its centre, and the inertia about the origin of the body's frame: (m, m c,
Ixx, Iyy, Izz, Ixy, Ixz, Iyz). The regressor Y_b needs the motion alone, so that other masses cost a
product of matrices.

Source: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and
links, 1986; Featherstone, Rigid body dynamics algorithms, 2008, chapters 2 and 5; Khalil and
Dombre, Modeling, identification and control of robots, 2002, section 12.3.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

PARAMETERS = 10
# where Ixx, Iyy, Izz, Ixy, Ixz and Iyz stand in a matrix
PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def inertial_parameters(
    mass: np.ndarray, centre: np.ndarray, inertia: np.ndarray, quaternion: np.ndarray
) -> np.ndarray:
    """π (nbody, 10) of bodies as MuJoCo has them.

    Args:
        mass: (nbody,) kg; centre: (nbody, 3) m; inertia: (nbody, 3) kg·m² about the centre along
            axes that `quaternion` (nbody, 4) turns.
    """
    axes = np.array([_matrix(one) for one in quaternion])
    about_centre = np.einsum("bij,bj,bkj->bik", axes, inertia, axes)
    square = np.einsum("bi,bi->b", centre, centre)[:, None, None] * np.eye(3)
    shift = square - centre[:, :, None] * centre[:, None, :]
    about_origin = about_centre + mass[:, None, None] * shift
    columns = [about_origin[:, i, j] for i, j in PLACES]
    return np.column_stack([mass, mass[:, None] * centre, *columns])


def inverse_dynamics(
    model: mujoco.MjModel, dofs: Sequence[int], motion: Sequence[np.ndarray], gravity: np.ndarray
) -> np.ndarray:
    """N·m (n, place), or N of a slide, that the bodies of a model take.

    Args:
        dofs: (n,) of hinges and slides that move; the others rest where the model has them.
        motion: their positions, velocities and accelerations (n, place).
        gravity: (3,) m/s².
    """
    own = inertial_parameters(
        model.body_mass, model.body_ipos, model.body_inertia, model.body_iquat
    )
    out = np.zeros(np.shape(motion[0]))
    for body, frame in _frames(model, dofs, motion, gravity):
        force, moment = (np.einsum("ikn,k->in", by, own[body]) for by in frame.wrench())
        frame.add(out, force, moment)
    return out


def regressor(
    model: mujoco.MjModel, dofs: Sequence[int], motion: Sequence[np.ndarray], gravity: np.ndarray
) -> np.ndarray:
    """Y (nbody, n, 10, place), of `inverse_dynamics`, which has the arguments."""
    n, places = np.shape(motion[0])
    out = np.zeros((model.nbody, n, PARAMETERS, places))
    for body, frame in _frames(model, dofs, motion, gravity):
        frame.add(out[body], *frame.wrench())
    return out


@dataclass(frozen=True)
class _Frame:
    """The frame of a body at many places.

    Attributes:
        turn: (3, 3, place) its axes in the world's; at: (3, place) m, its origin.
        angular, turning: (3, place) rad/s and rad/s² in the world's axes.
        linear: (3, place) m/s² of its origin there, beyond a free fall.
        moved_by: (joint, axis (3, place), anchor (3, place)) of the joints on the way to it; no
            anchor of a slide.
    """

    turn: np.ndarray
    at: np.ndarray
    angular: np.ndarray
    turning: np.ndarray
    linear: np.ndarray
    moved_by: tuple[tuple[int, np.ndarray, np.ndarray | None], ...] = ()

    def fixed(self, position: np.ndarray, quaternion: np.ndarray) -> "_Frame":
        """One that is fixed in this one."""
        arm = _turned(self.turn, position)
        linear, at = self._linear_at(arm), self.at + arm
        turn = np.einsum("ijn,jk->ikn", self.turn, _matrix(quaternion))
        return replace(self, turn=turn, at=at, linear=linear)

    def slid(self, joint: int, axis: np.ndarray, motion: Sequence[np.ndarray]) -> "_Frame":
        """It after a slide along an axis (3,) of its own, by a motion of (place,) each."""
        q, dq, ddq = motion
        along = _turned(self.turn, axis)
        arm = along * q
        linear = self._linear_at(arm) + 2 * dq * _cross(self.angular, along) + ddq * along
        moved_by = (*self.moved_by, (joint, along, None))
        return replace(self, at=self.at + arm, linear=linear, moved_by=moved_by)

    def hinged(
        self, joint: int, axis: np.ndarray, anchor: np.ndarray, motion: Sequence[np.ndarray]
    ) -> "_Frame":
        """It after a hinge at an anchor (3,) of its own."""
        q, dq, ddq = motion
        along, arm = _turned(self.turn, axis), _turned(self.turn, anchor)
        about = self.at + arm
        turning = self.turning + ddq * along + dq * _cross(self.angular, along)
        turn = (self.turn[:, :, None] * _rotation(axis, q)).sum(axis=1)
        after = _Frame(
            turn, about, self.angular + dq * along, turning, self._linear_at(arm),
            (*self.moved_by, (joint, along, about)),
        )  # fmt: skip
        back = _turned(turn, -anchor)
        return replace(after, at=about + back, linear=after._linear_at(back))

    def _linear_at(self, arm: np.ndarray) -> np.ndarray:
        centripetal = _cross(self.angular, _cross(self.angular, arm))
        return self.linear + _cross(self.turning, arm) + centripetal

    def wrench(self) -> tuple[np.ndarray, np.ndarray]:
        """Force and moment (3, 10, place) about the origin by π, along its own axes."""
        own = self.turn.swapaxes(0, 1)
        angular, turning, linear = (
            _turned(own, v) for v in (self.angular, self.turning, self.linear)
        )
        force, moment = np.zeros((2, 3, PARAMETERS, linear.shape[-1]))
        force[:, 0] = linear
        for i, unit in enumerate(np.eye(3)[:, :, None]):
            force[:, 1 + i] = _cross(turning, unit) + _cross(angular, _cross(angular, unit))
            moment[:, 1 + i] = _cross(unit, linear)
        for k, (i, j) in enumerate(PLACES, 4):
            # I α + ω × I ω of an inertia that is 1 in one place
            carried = np.zeros_like(angular)
            carried[i] = angular[j]
            moment[i, k] = turning[j]
            if i != j:
                carried[j], moment[j, k] = angular[i], turning[i]
            moment[:, k] += _cross(angular, carried)
        return force, moment

    def add(self, torque: np.ndarray, force: np.ndarray, moment: np.ndarray) -> None:
        """To torques (n, …, place) what a wrench (3, …, place) in its own axes asks of joints."""
        own = self.turn.swapaxes(0, 1)
        for joint, along, about in self.moved_by:
            axis = _turned(own, along)
            if about is None:
                torque[joint] += np.einsum("in,i...n->...n", axis, force)
            else:
                lever = _turned(own, _cross(along, self.at - about))
                torque[joint] += np.einsum("in,i...n->...n", lever, force)
                torque[joint] += np.einsum("in,i...n->...n", axis, moment)


def _frames(
    model: mujoco.MjModel, dofs: Sequence[int], motion: Sequence[np.ndarray], gravity: np.ndarray
) -> Iterator[tuple[int, _Frame]]:
    """Bodies and their frames, each after its parent; without the world."""
    joint_of = {int(dof): i for i, dof in enumerate(dofs)}
    still = np.zeros_like(motion[0][:1].repeat(3, axis=0))
    world = np.repeat(np.eye(3)[:, :, None], still.shape[1], axis=2)
    frames = [_Frame(world, still, still, still, still - np.asarray(gravity)[:, None])]
    for body in range(1, model.nbody):
        frame = frames[model.body_parentid[body]]
        frame = frame.fixed(model.body_pos[body], model.body_quat[body])
        first = model.body_jntadr[body]
        for own in range(first, first + model.body_jntnum[body]):
            joint = joint_of.get(int(model.jnt_dofadr[own]))
            if joint is None:
                continue
            q, dq, ddq = (values[joint] for values in motion)
            moved = q - model.qpos0[model.jnt_qposadr[own]], dq, ddq
            axis = model.jnt_axis[own]
            if model.jnt_type[own] == mujoco.mjtJoint.mjJNT_SLIDE:
                frame = frame.slid(joint, axis, moved)
            else:
                frame = frame.hinged(joint, axis, model.jnt_pos[own], moved)
        frames.append(frame)
        yield body, frame


def _rotation(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(3, 3, place) about an axis (3,) of length 1 (Rodrigues)."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])[:, :, None]
    square = (np.outer(axis, axis) - np.eye(3))[:, :, None]
    return np.eye(3)[:, :, None] + np.sin(angle) * across + (1 - np.cos(angle)) * square


def _matrix(quaternion: np.ndarray) -> np.ndarray:
    """(3, 3)."""
    turned = np.empty(9)
    mujoco.mju_quat2Mat(turned, quaternion)
    return turned.reshape(3, 3)


def _turned(turn: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(3, place) of a vector (3,) or (3, place)."""
    return turn[:, 0] * vector[0] + turn[:, 1] * vector[1] + turn[:, 2] * vector[2]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b, (3, place)."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
