"""The whole of a configuration file."""

from typing import Annotated, Any, Literal

from pydantic import Field

from t2l.config.models.actions import ClonedActions
from t2l.config.models.attenuation import Attenuation
from t2l.config.models.cloning import (
    CloningGrid,
    Demonstrations,
    Fidelity,
    Operator,
    Retargeting,
    Rollouts,
    Training,
    Variant,
)
from t2l.config.models.decoupling import Decoupling
from t2l.config.models.diagnosis import Diagnosis
from t2l.config.models.experiment import RobotAblation, SimToReal, TransferDecision
from t2l.config.models.landscape import Landscape
from t2l.config.models.learning import ReinforcementLearning, Tuning
from t2l.config.models.observation import Observation
from t2l.config.models.scoreboard import Scoreboard
from t2l.config.models.task_learning import Learning
from t2l.config.models.transfer import (
    Deployment,
    Identification,
    RecordingGrid,
    Recordings,
    Robot,
)
from t2l.config.quantities import LARGEST_SEED, Given, Paths
from t2l.typed import Integer, Name, Typed, Unique


def _section(model: type[Typed], description: str) -> Any:
    return Field(default_factory=model, description=description)


class Configuration(Typed):
    """What a configuration file holds; keys that are absent have their defaults."""

    study: Name = Field(
        description="name of the folder in `results/`; two studies never share an artefact"
    )
    seed: Integer = Field(
        0,
        ge=0,
        le=LARGEST_SEED,
        description="base seed; every stage derives its own from it, the task and the cell",
    )
    extensions: Annotated[Paths | None, Given] = Field(
        None,
        description="Python files, or folders of them, with robots, tasks, action spaces, "
        "policies, algorithms and back ends of your own; they run where T2L_TRUST=1 is set",
    )
    tasks: Annotated[list[Name], Field(min_length=1, max_length=100), Unique] = Field(
        ["block_stack"],
        description="names of files in `config/tasks/`; p values are corrected for their number",
    )
    grid: CloningGrid = _section(
        CloningGrid,
        "the cells of behaviour cloning; `compliant_up_to_kp` and `overdamped_from_kd` bound the "
        "compliant, overdamped region G^CO",
    )
    demonstrations: Demonstrations = _section(Demonstrations, "demonstrations of the expert")
    observation: Observation = _section(Observation, "what cloned policies see")
    actions: ClonedActions = _section(ClonedActions, "what the output of cloned policies means")
    operator: Annotated[Operator | None, Given] = Field(
        None,
        description="who demonstrates in each cell, through its controller: a model of a person, "
        "whose attempts `demonstrations` counts; without this section the expert's demonstrations "
        "are retargeted",
    )
    retargeting: Retargeting = _section(
        Retargeting, "how demonstrations become position commands for the gains of a cell"
    )
    fidelity: Fidelity = _section(
        Fidelity, "the validation of retargeting, in every combination of what follows"
    )
    training: Training = _section(Training, "training of the policy")
    rollouts: Rollouts = _section(Rollouts, "rollouts of cloned policies")
    training_seeds: Integer = Field(
        1,
        ge=1,
        le=100,
        description="how many policies each cell has, each trained from a seed of its own",
    )
    collections: Integer = Field(
        1,
        ge=1,
        le=100,
        description="how many collections each task has: demonstrations and starts of rollouts, "
        "drawn anew, each with policies of its own; figures show the first, the table "
        "`collections` compares regions with the collection as the unit",
    )
    training_jobs: Literal["policy", "variant"] = Field(
        "policy",
        description="what one job trains: a `policy`, or all policies of a task and a `variant`, "
        "and of a condition of transfer, side by side, which a GPU does in the time of one",
    )
    variants: Annotated[dict[Name, Variant], Field(max_length=100)] = Field(
        {},
        description="by a name each: what differs from all that is said elsewhere, which is the "
        "variant `nominal`",
    )
    attenuation: Attenuation = _section(
        Attenuation, "what the controllers of `grid` leave of errors of commands"
    )
    recording_grid: RecordingGrid = _section(
        RecordingGrid,
        "the cells of sim-to-real transfer; the figures outline the stiff, overdamped region G^SO, "
        "above `compliant_up_to_kp` and from `overdamped_from_kd` up",
    )
    sim_to_real: SimToReal = _section(SimToReal, "what is transferred")
    robot: Robot = _section(Robot, "the robot at the other end")
    recordings: Recordings = _section(
        Recordings,
        "the motion that is recorded for identification, about home on all joints",
    )
    identification: Identification = _section(
        Identification, "of the actuators of the training simulators"
    )
    reinforcement_learning: ReinforcementLearning = _section(
        ReinforcementLearning,
        "learning in the identified simulator",
    )
    tuning: Tuning = _section(
        Tuning, "Optuna's search for action scales, a study for each cell and condition"
    )
    deployment: Deployment = _section(Deployment, "rollouts of tuned policies")
    robot_ablation: Annotated[RobotAblation | None, Given] = Field(
        None,
        description="which effect of the virtual robot makes policies shake: each is left out in "
        "turn; without this section none is",
    )
    transfer_decision: Annotated[TransferDecision | None, Given] = Field(
        None,
        description="how it is decided whether the study's claim about transfer is reproduced; a "
        "study that is too small for its own rule is refused; without this section nothing is "
        "decided",
    )
    landscape: Annotated[Landscape | None, Given] = Field(
        None,
        description="how easily action scales are found at the corners, and whether they work "
        "again; without this section it is not asked",
    )
    decoupling: Annotated[Decoupling | None, Given] = Field(
        None,
        description="policies that hold a pose more stiffly, or more softly, than their gains; "
        "without this section there are none",
    )
    learning: Annotated[Learning | None, Given] = Field(
        None,
        description="tasks that are learned in simulation alone, under the gains as they are, such "
        "as those with contacts; without this section there are none",
    )
    scoreboard: Annotated[Scoreboard | None, Given] = Field(
        None,
        description="what else the table of the study's statements is made of; without this "
        "section it is made of this study's results alone",
    )
    diagnosis: Annotated[Diagnosis | None, Given] = Field(
        None,
        description="what the target `diagnosis` explains; paths are relative to the project's "
        "folder; without this section there is no diagnosis",
    )
