"""``t2l retarget``: a LeRobot data set as if it had been recorded under other gains."""

import argparse
from pathlib import Path

from t2l.cli.dataset import add_dataset_arguments
from t2l.cli.inputs import add_extensions, add_force
from t2l.cli.words import numbers

HELP = "make a LeRobot data set one of other gains"

DESCRIPTION = """\
Copy a LeRobot data set on disk (format 3) with the commands that a controller of other gains would
have needed for the same motion. `action` is the commanded position under the gains of the data set,
`observation.state` the measured one. Velocities are taken from `observation.state` if it has them,
else from differences of positions. Gravity must be cancelled under both gains in the same way. What
is no joint, such as a gripper, stays as it is.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.description = DESCRIPTION
    add_dataset_arguments(parser, "folder for the new data set")
    for which, gains in (("", "that it was recorded under"), ("to-", "wanted")):
        for gain, unit in (("kp", "N·m/rad"), ("kd", "N·m·s/rad")):
            parser.add_argument(
                f"--{which}{gain}",
                type=numbers,
                required=True,
                help=f"{gains}, {unit}, one number or one for each joint: 1,2",
            )
    add_extensions(parser)
    add_force(parser)


def run(arguments: argparse.Namespace) -> None:
    """Check the whole data set, then write the other.

    Raises:
        ConfigurationError: no such robot or joint.
        InputError: gains are no gains.
        RecordingError: torques cannot be reconstructed; nothing is written.
        OutputError: the folder is not the command's.
    """
    import os
    from tempfile import TemporaryDirectory

    from t2l.cli.inputs import gain_of_each
    from t2l.demos.other_gains import ENTRIES, Gains, retarget_dataset, write_retargeted
    from t2l.outputs import output_folder
    from t2l.registry import python_files
    from t2l.robots import plant
    from t2l.sim.loop import torque_limits

    def gains(which: str) -> Gains:
        return Gains(
            *(
                gain_of_each(arguments, f"{which}{gain}", arguments.joints, zero=gain == "kd")
                for gain in ("kp", "kd")
            )
        )

    model = plant.compiled(plant.load(arguments.robot, arguments.joints), arguments.robot)
    found = retarget_dataset(
        arguments.dataset,
        arguments.joints,
        gains(""),
        gains("to_"),
        abs(torque_limits(model, tuple(arguments.joints))).min(axis=1),
        plant.position_ranges(model, arguments.joints),
        arguments.degrees,
        arguments.action_indices,
        arguments.state_indices,
    )
    read = [arguments.dataset, *python_files(arguments.extensions)]
    with (
        output_folder(
            arguments.out, "t2l retarget", ENTRIES, read, arguments.force, once=True
        ) as out,
        TemporaryDirectory(dir=out, prefix=".draft-") as draft,
    ):
        write_retargeted(found, arguments.dataset, Path(draft))
        # what says that the data set is whole comes last
        for entry in ENTRIES:
            if (Path(draft) / entry).exists():
                os.replace(Path(draft) / entry, out / entry.rstrip("/"))
    before, after = found.lead_rad
    print(
        f"{arguments.out}: {len(found.episodes)} episodes; commands lie up to {after:.3g} rad from "
        f"where the robot is ({before:.3g} before)"
    )
