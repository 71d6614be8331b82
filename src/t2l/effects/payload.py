"""A mass at the flange that the controller does not know."""

import mujoco
import numpy as np

from t2l.effects.effect import Effect, Parameter, Scales

SITES = ("attachment_site", "flange", "tip", "end_effector", "ee", "tcp")
BODY = "payload"
ON_AXIS_M = 1e-3  # numerics: a flange so near the last joint's axis, where a mass moves nothing
USUAL_ARM_M = 0.3  # guess: of a load about its joint


class Payload(Effect):
    """A point mass at the flange; gravity compensation does not carry it."""

    name = "payload"
    title = "payload"
    parameters = (
        Parameter("mass", "kg", 0.0, 10.0, "mass at the flange", per_joint=False, scale="mass"),
        *(
            Parameter(
                f"com_{axis}", "m", -0.5, 0.5, f"centre of mass from the flange, {axis}",
                per_joint=False, size=0.01,
            )
            for axis in "xyz"
        ),
    )  # fmt: skip
    summary = "a mass at the flange that neither model nor gravity compensation knows"
    signature = "the error follows the gravity load of the last link, on every joint that bears it"
    source = "Newton-Euler; MuJoCo, XML reference, body/inertial"
    remembers = False
    follows = "gravity"

    def extend(self, spec, joints):
        body = spec.joint(joints[-1]).parent
        chain = [body]
        while len(list(chain[-1].bodies)) == 1 and not list(next(iter(chain[-1].bodies)).joints):
            chain.append(next(iter(chain[-1].bodies)))
        sites = {site.name: (link, site) for link in chain for site in link.sites}
        parent, position = body, np.zeros(3)
        for name in SITES:
            if name in sites:
                parent, position = sites[name][0], sites[name][1].pos
        parent.add_body(
            name=BODY, pos=position, mass=0.0, inertia=(0.0,) * 3, explicitinertial=True
        )

    def export(self, to, joints, values):
        body = to.spec.body(BODY)
        body.mass = values["mass"]
        body.ipos = [values[f"com_{axis}"] for axis in "xyz"]

    def install(self, loop, rows, joints, values):
        loop.inertia_changed = True
        body = loop.batch.model.body(BODY).id
        loop.batch.expand("body_mass")[rows, body] = values["mass"][:, 0]
        position = np.concatenate([values[f"com_{axis}"] for axis in "xyz"], axis=1)
        loop.batch.expand("body_ipos")[rows, body] = position

    def starts(self, scales):
        centres, arm_m, factors = np.zeros((1, 3)), USUAL_ARM_M, (0.05, 0.3, 1.0)
        if _distance(*_last_joint(scales), _flange(scales)) < ON_AXIS_M:
            centres, arm_m = _around_the_axis(scales)
            factors = (0.03, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0)  # mass and arm can trade
        mass = scales.torque.max() / (9.81 * arm_m)
        return [
            {"mass": np.array([factor * mass])}
            | {f"com_{axis}": centre[i : i + 1] for i, axis in enumerate("xyz")}
            for factor in factors
            for centre in centres
        ]


def _last_joint(scales: Scales) -> tuple[np.ndarray, np.ndarray]:
    """Axis and anchor in the frame of its body, (3,) each; no axis of a slide."""
    model = scales.plant
    joint = model.joint(scales.joints[-1]).id
    slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    return np.full(3, np.nan) if slides else model.jnt_axis[joint], model.jnt_pos[joint]


def _distance(axis: np.ndarray, anchor: np.ndarray, point: np.ndarray) -> float:
    return float(np.linalg.norm(np.cross(axis, point - anchor)))


def _around_the_axis(scales: Scales) -> tuple[np.ndarray, float]:
    """Places (n, 3) where a mass moves the last joint, as far out as its link, and that in m."""
    model, (axis, anchor) = scales.plant, _last_joint(scales)
    out = model.body_ipos[model.jnt_bodyid[model.joint(scales.joints[-1]).id]] - anchor
    out = out - (out @ axis) * axis
    if np.linalg.norm(out) < ON_AXIS_M:
        # numerics: no axis is parallel to it
        out = USUAL_ARM_M * np.cross(axis, np.roll(axis, 1) + np.array([0.3, 0.2, 0.1]))
    across = np.cross(axis, out)
    places = [far * way for far in (1, 2) for way in (out, across, -out, -across)]
    return np.array(places), float(np.linalg.norm(out))


def _flange(scales: Scales) -> np.ndarray:
    """Where the payload is put, in the frame of the last joint's body, (3,) m."""
    model = scales.plant
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body = model.jnt_bodyid[model.joint(scales.joints[-1]).id]
    at = data.xpos[body]
    for name in SITES:
        site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, name)
        if site >= 0:
            at = data.site_xpos[site]
    return data.xmat[body].reshape(3, 3).T @ (at - data.xpos[body])
