"""Links whose mass, centre of mass and inertia are not the model's."""

import mujoco
import numpy as np

from t2l.effects.effect import Effect, Parameter

TRIED_M = 0.03  # guess: shift of a first guess


class LinkInertia(Effect):
    """m → a m, c → c + δ, I_c → a b I_c, for the link that a joint moves.

    Every value is a body that can exist: mass and inertia about the centre of mass are positive
    and keep the MJCF's triangle inequality, so that the pseudo-inertia is positive definite.
    """

    name = "link_inertia"
    title = "mass and inertia of a link"
    parameters = (
        Parameter("mass_factor", "1", 0.02, 50.0, "real over modelled mass, a", 1.0, log=True),
        *(
            Parameter(
                f"com_{axis}", "m", -0.5, 0.5, f"shift of the centre of mass, {axis} of the link",
                size=0.01,
            )
            for axis in "xyz"
        ),
        Parameter(
            "inertia_factor", "1", 0.05, 20.0,
            "real over modelled inertia about the centre of mass, beside the mass's, b", 1.0,
            log=True,
        ),
    )  # fmt: skip
    summary = "a link is heavier, lighter or otherwise balanced than model and compensation think"
    signature = "the error follows the gravity load and the acceleration of one link"
    source = (
        "Wensing et al., Linear matrix inequalities for physically consistent inertial parameter "
        "identification, 2018"
    )
    remembers = False
    follows = "gravity"
    coupled = True

    def export(self, to, joints, values):
        to.other_weight.append(self.name)
        model = to.spec.compile()
        for i, body in enumerate(_links(model, to.joints, joints)):
            link = to.spec.body(model.body(body).name)
            factor = values["mass_factor"][i]
            link.mass *= factor
            link.ipos = link.ipos + np.array([values[f"com_{axis}"][i] for axis in "xyz"])
            link.inertia = link.inertia * factor * values["inertia_factor"][i]

    def install(self, loop, rows, joints, values):
        loop.inertia_changed = True
        bodies = _links(loop.batch.model, loop.joints, joints)
        factor = values["mass_factor"]
        loop.batch.expand("body_mass")[rows, bodies] *= factor
        inertia = (factor * values["inertia_factor"])[:, :, None]
        loop.batch.expand("body_inertia")[rows, bodies] *= inertia
        shift = np.stack([values[f"com_{axis}"] for axis in "xyz"], axis=2)
        loop.batch.expand("body_ipos")[rows, bodies] += shift
        loop.other_weight[rows] = True

    def starts(self, scales):
        one = np.ones_like(scales.torque)

        def guess(mass, shift=(0.0, 0.0, 0.0)):
            return {
                "mass_factor": mass * one,
                **{f"com_{a}": s + 0.0 * one for a, s in zip("xyz", shift, strict=True)},
                "inertia_factor": one,
            }

        ways = _across(scales.plant, scales.joints)
        shifts = [size * way for way in ways for size in (TRIED_M, -TRIED_M)]
        return [*map(guess, (0.9, 1.1, 0.5, 2.0)), *(guess(1.0, shift) for shift in shifts)]


def _across(model: mujoco.MjModel, names: tuple[str, ...]) -> np.ndarray:
    """Two directions across each joint's axis, (2, 3, njoint): along it a mass moves no torque."""
    axes = np.array([model.jnt_axis[model.joint(name).id] for name in names])
    least = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    first = np.cross(axes, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first.T, np.cross(axes, first).T])


def _links(model: mujoco.MjModel, names: tuple[str, ...], joints: np.ndarray) -> list[int]:
    """For each joint the heaviest body of those that move with it as one."""
    found = []
    for j in joints:
        first = model.jnt_bodyid[model.joint(names[j]).id]
        rigid = [first]
        for body in range(first + 1, model.nbody):
            if model.body_parentid[body] in rigid and model.body_jntnum[body] == 0:
                rigid.append(body)
        found.append(int(max(rigid, key=lambda body: model.body_mass[body])))
    return found
