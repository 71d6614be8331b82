"""Which robots there are."""

from functools import cache

from t2l.registry import Registry
from t2l.robots.robot import Robot

ROBOTS: Registry[Robot] = Registry(
    "robot",
    Robot,
    {
        "fr3": "t2l.robots.fr3:FR3",
        "fr3_hand": "t2l.robots.fr3:FR3Hand",
        "fr3_duo": "t2l.robots.fr3_duo:FR3Duo",
        "ur5e": "t2l.robots.ur5e:UR5e",
        "ur5e_2f85": "t2l.robots.ur5e:UR5e2F85",
        "unitree_g1": "t2l.robots.unitree_g1:UnitreeG1",
        "allegro_hand": "t2l.robots.allegro_hand:AllegroHand",
    },
)


def make_robot(name: str) -> Robot:
    """The robot of a name, the same object each time.

    Raises:
        ConfigurationError: there is none.
    """
    return _made(ROBOTS.find(name))


@cache
def _made(cls: type[Robot]) -> Robot:
    return cls()
