"""The environment as lerobot's commands know it: what may follow `--env.`."""

import re
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated

from draccus.utils import DecodingError
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs import EnvConfig
from pydantic import AfterValidator, Field

from lerobot_env_t2l.environment import OBSERVED_AS, PIXELS, BatchEnvironment
from lerobot_env_t2l.fit import check_dataset, check_policy
from t2l.actions import make_control
from t2l.config import SIMULATION_RATE_HZ
from t2l.config.actions import of_actions
from t2l.config.models.actions import Actions
from t2l.config.models.cloning import Retargeting
from t2l.config.models.observation import Observation
from t2l.config.quantities import Gain, Text
from t2l.config.tasks import read_task
from t2l.demos.dataset import ACTION, ENVIRONMENT, IMAGES, STATE, policy_features
from t2l.errors import ConfigurationError, T2LError
from t2l.gains import Cell
from t2l.registry import check_trusted, load_extensions, python_files
from t2l.tasks import Demonstrated, make_task
from t2l.tasks.cameras import check_cameras
from t2l.typed import Integer, Invalid, Typed, check, refuse

TASKS = Path("config/tasks")
_TYPES = {STATE: FeatureType.STATE, ENVIRONMENT: FeatureType.ENV, ACTION: FeatureType.ACTION}


def _divisor(rate: int) -> int:
    if SIMULATION_RATE_HZ % rate:
        raise refuse(f"a divisor of the simulation's {SIMULATION_RATE_HZ} Hz")
    return rate


class Settings(Typed):
    """What `T2LEnvConfig` may hold."""

    task: Text = Field(description="the name of a file in config/tasks, or the path of one")
    kp: Gain = Field(description="a stiffness Kp, N·m/rad; with task_pose 1/s²")
    kd: Gain = Field(description="a damping Kd, N·m·s/rad; with task_pose 1/s")
    fps: Annotated[Integer, Field(ge=1), AfterValidator(_divisor)]
    actions: Actions
    observation: Observation
    extensions: list[Text]
    threads: Annotated[Integer, Field(ge=1, le=1000)]
    picture_hz: Annotated[Integer, Field(ge=0)]


def _named_in_command() -> set[str]:
    """Paths that the command line gives as extensions; that of a saved configuration names none."""
    option, found = "--env.extensions", set()
    for argument, following in zip(sys.argv, [*sys.argv[1:], ""], strict=True):
        value = following if argument == option else argument.removeprefix(f"{option}=")
        if argument == option or value != argument:
            found.update(re.split(r"[\[\],'\"\s]+", value))
    return found - {""}


@dataclass
class ActionsConfig:
    """What the policy's actions mean, as under `actions` of a configuration of t2l."""

    kind: str = Actions().kind
    reference: str | None = None


@dataclass
class ObservationConfig:
    """What the policy sees, as under `observation` of a configuration of t2l."""

    cameras: list[str] = field(default_factory=list)
    size_px: int = Observation().size_px


@EnvConfig.register_subclass("t2l")
@dataclass
class T2LEnvConfig(EnvConfig):
    """A task of t2l under the gains of a cell.

    Attributes:
        task: the name of a file in config/tasks, or the path of one.
        kp, kd: the gains.
        fps: rate of the policy, Hz.
        actions: what its actions mean.
        observation: cameras whose pictures it sees in place of the environment's state.
        extensions: Python files of your own that the task needs.
        threads: that simulate; they change no result.
        picture_hz: new pictures a second in videos; 0 draws only how an episode begins and ends.
    """

    kp: float | None = None
    kd: float | None = None
    fps: int = Retargeting().policy_rate_hz
    actions: ActionsConfig = field(default_factory=ActionsConfig)
    observation: ObservationConfig = field(default_factory=ObservationConfig)
    extensions: list[str] = field(default_factory=list)
    threads: int = 1
    # software draws about 20 a second, and lerobot shows ten episodes
    picture_hz: int = 5

    def __post_init__(self) -> None:
        try:
            self._make()
        except (T2LError, Invalid) as error:
            # lerobot prints this one without a traceback
            raise DecodingError(("env",), str(error)) from None

    def _make(self) -> None:
        own = asdict(self)
        own["actions"] = {key: value for key, value in own["actions"].items() if value is not None}
        given = {key: own[key] for key in Settings.model_fields if own[key] is not None}
        settings = check(Settings, given)
        named = [path for path in settings.extensions if path in _named_in_command()]
        # a saved configuration may hold extensions too
        check_trusted(
            python_files(settings.extensions), "env.extensions", python_files(named)
        )  # fmt: skip
        load_extensions(settings.extensions)
        if problems := list(of_actions("actions", settings.actions)):
            raise Invalid(problems)
        path = Path(settings.task)
        folder = path.parent if path.suffix == ".yaml" else TASKS
        task = make_task(read_task("env.task", path.name.removesuffix(".yaml"), folder))
        if not isinstance(task, Demonstrated):
            raise ConfigurationError(
                f"task: found {settings.task!r}; allowed: a task that an expert can demonstrate"
            )
        cell = Cell(settings.kp, settings.kd)
        self._task = task
        self._control = make_control(own["actions"], cell, task.robot, task.model)
        self._cameras = asdict(self.observation)
        if self.observation.cameras:
            scene = task.spec(visual=True)
            check_cameras([camera.name for camera in scene.cameras], self.observation.cameras)
        self._held = policy_features(task, self._control.actions.names, **self._cameras)
        self.features_map = {_shown_as(key): key for key in self._held}
        self.features = {
            name: PolicyFeature(_TYPES.get(key, FeatureType.VISUAL), self._held[key]["shape"])
            for name, key in self.features_map.items()
        }

    @property
    def gym_kwargs(self) -> dict:
        """None: nothing here goes through gymnasium's registry."""
        return {}

    def create_envs(
        self, n_envs: int, use_async_envs: bool = False
    ) -> dict[str, dict[int, BatchEnvironment]]:
        """One vector environment; its simulations step together in threads, not in processes.

        Raises:
            ConfigurationError: the policy that lerobot was given does not fit it.
        """
        check_policy(self._held)
        environment = BatchEnvironment(
            self._task,
            self._control,
            n_envs,
            SIMULATION_RATE_HZ // self.fps,
            self.threads,
            self.picture_hz,
            **self._cameras,
        )
        return {self.type: {0: environment}}

    def get_env_processors(self):
        """None are needed; lerobot asks for them before it trains.

        Raises:
            ConfigurationError: the data set that lerobot was given does not fit the environment.
        """
        check_dataset(self._held, self.fps)
        return super().get_env_processors()


def _shown_as(key: str) -> str:
    """What lerobot calls a feature of a data set where an environment gives it."""
    if key.startswith(IMAGES):
        return f"{PIXELS}/{key.removeprefix(IMAGES)}"
    return OBSERVED_AS.get(key, key)
