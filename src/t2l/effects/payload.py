"""A mass at the flange that the controller does not know."""

import numpy as np

from t2l.effects.effect import Effect, Parameter

SITES = ("attachment_site", "flange", "tip", "end_effector", "ee", "tcp")
BODY = "payload"


class Payload(Effect):
    """A point mass at the flange; gravity compensation does not carry it."""

    name = "payload"
    title = "payload"
    parameters = (
        Parameter("mass", "kg", 0.0, 50.0, "mass at the flange", per_joint=False),
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
            name=BODY, pos=position, mass=1e-6, inertia=(1e-9,) * 3, explicitinertial=True
        )

    def export(self, to, joints, values):
        self.extend(to.spec, to.joints)
        body = to.spec.body(BODY)
        body.mass = max(values["mass"], 1e-6)
        body.ipos = [values[f"com_{axis}"] for axis in "xyz"]

    def install(self, loop, rows, joints, values):
        loop.inertia_changed = True
        body = loop.batch.model.body(BODY).id
        loop.batch.expand("body_mass")[rows, body] = np.maximum(values["mass"][:, 0], 1e-6)
        position = np.concatenate([values[f"com_{axis}"] for axis in "xyz"], axis=1)
        loop.batch.expand("body_ipos")[rows, body] = position

    def starts(self, scales):
        mass = scales.torque.max() / (9.81 * 0.3)
        return [
            {"mass": np.array([factor * mass]), **{f"com_{a}": np.zeros(1) for a in "xyz"}}
            for factor in (0.05, 0.3, 1.0)
        ]
