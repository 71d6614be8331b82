"""Inverse dynamics are linear in the inertial parameters of each body: τ = Σ Y_b π_b.

π_b is the mass, the mass times the position of its centre, and the inertia about the origin of the
body's frame: (m, m c, Ixx, Iyy, Izz, Ixy, Ixz, Iyz). The regressor Y_b needs the motion alone, so
that other masses cost a product of matrices.

Source: Atkeson, An and Hollerbach, Estimation of inertial parameters of manipulator loads and
links, 1986; Khalil and Dombre, Modeling, identification and control of robots, 2002, section 12.3.
"""

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
    turned = np.empty((len(mass), 9))
    for one, q in zip(turned, quaternion, strict=True):
        mujoco.mju_quat2Mat(one, q)
    axes = turned.reshape(-1, 3, 3)
    about_centre = np.einsum("bij,bj,bkj->bik", axes, inertia, axes)
    square = np.einsum("bi,bi->b", centre, centre)[:, None, None] * np.eye(3)
    shift = square - centre[:, :, None] * centre[:, None, :]
    about_origin = about_centre + mass[:, None, None] * shift
    columns = [about_origin[:, i, j] for i, j in PLACES]
    return np.column_stack([mass, mass[:, None] * centre, *columns])


def regressor(model: mujoco.MjModel, data: mujoco.MjData, dofs: np.ndarray) -> np.ndarray:
    """Y (nbody, n, 10) of the joints with `dofs` (n,) where `mj_inverse` has just been called.

    N·m, or N of a slide; what gravity asks for is in it.
    """
    mujoco.mj_rnePostConstraint(model, data)
    found = np.zeros((model.nbody, len(dofs), PARAMETERS))
    spatial, moving = np.zeros(6), np.zeros(6)
    linear, angular = np.zeros((2, 3, model.nv))
    frame = mujoco.mjtObj.mjOBJ_XBODY
    for body in range(1, model.nbody):
        # of the frame's origin, along its own axes; the acceleration holds that of a free fall
        mujoco.mj_objectAcceleration(model, data, frame, body, spatial, 1)
        mujoco.mj_objectVelocity(model, data, frame, body, moving, 1)
        mujoco.mj_jac(model, data, linear, angular, data.xpos[body], body)
        turn = data.xmat[body].reshape(3, 3)
        by_force, by_moment = (j[:, dofs].T @ turn for j in (linear, angular))
        turning, accelerated = _cross(moving[:3]), _cross(spatial[:3])
        falling = _cross(spatial[3:])
        by_inertia = _times(spatial[:3]) + turning @ _times(moving[:3])
        found[body, :, 0] = by_force @ spatial[3:]
        found[body, :, 1:4] = by_force @ (accelerated + turning @ turning) - by_moment @ falling
        found[body, :, 4:] = by_moment @ by_inertia
    return found


def _cross(a: np.ndarray) -> np.ndarray:
    """The matrix of a × ·."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def _times(w: np.ndarray) -> np.ndarray:
    """(3, 6), which gives I w of an inertia (Ixx, Iyy, Izz, Ixy, Ixz, Iyz)."""
    return np.array(
        [[w[0], 0, 0, w[1], w[2], 0], [0, w[1], 0, w[0], 0, w[2]], [0, 0, w[2], 0, w[0], w[1]]]
    )
