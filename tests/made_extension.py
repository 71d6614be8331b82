"""A Python file as a user would write it: a robot that the library does not know."""

from pathlib import Path

PENDULUM = '''"""A pendulum."""

from pathlib import Path

import mujoco

from t2l.robots import JointGroup, Robot


class Pendulum(Robot):
    """A link that hangs."""

    name = "{name}"
    groups = (
        JointGroup("arm", ("hinge",), 1, (0.0,), (5.0,), (10.0,), (100.0,), "attachment_site"),
    )

    def mjcf(self):
        """Beside this file."""
        return Path(__file__).with_name("pendulum.xml")

    def spec(self, gravity_compensation=True, visual=False):
        """The link alone."""
        return mujoco.MjSpec.from_file(str(self.mjcf()))
'''


def write_robot(path: Path, name: str) -> Path:
    """Write a file with a robot of this name, whose MJCF is pendulum.xml beside it."""
    path.write_text(PENDULUM.format(name=name))
    return path
