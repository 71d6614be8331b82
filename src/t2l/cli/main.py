"""``t2l COMMAND``: each command is a module with HELP, add_arguments and run."""

import argparse
import os
import sys
from collections.abc import Sequence

from t2l.cli import (
    adopt,
    advise,
    check,
    compare,
    diagnose,
    effects,
    explain,
    export,
    gains,
    import_csv,
    import_lerobot,
    import_rosbag,
    plan,
    propose,
    record,
    retarget,
    tune,
)
from t2l.cli.extras import extra_of
from t2l.cli.terminal import plain, printable
from t2l.errors import T2LError
from t2l.registry import load_extensions, trusting
from t2l.waiting import STATUS, interruptible

COMMANDS = {
    "compare": compare,
    "diagnose": diagnose,
    "adopt": adopt,
    "explain": explain,
    "propose": propose,
    "effects": effects,
    "gains": gains,
    "check": check,
    "export": export,
    "advise": advise,
    "tune": tune,
    "plan": plan,
    "record": record,
    "retarget": retarget,
    "import-csv": import_csv,
    "import-lerobot": import_lerobot,
    "import-rosbag": import_rosbag,
}

RESUME = "nothing is half-written; the same command begins again"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command that the arguments name; a mistake of the user ends with its message."""
    parser = argparse.ArgumentParser(prog="t2l")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, module in COMMANDS.items():
        module.add_arguments(
            commands.add_parser(
                name, help=module.HELP, formatter_class=argparse.RawDescriptionHelpFormatter
            )
        )
    parsed = parser.parse_args(arguments)
    command = COMMANDS[parsed.command]
    interrupted = f"t2l {parsed.command}: interrupted; {getattr(command, 'RESUME', RESUME)}"
    try:
        with interruptible(interrupted), printable(), trusting(getattr(parsed, "trust", False)):
            load_extensions(getattr(parsed, "extensions", []))
            command.run(parsed)
        sys.stdout.flush()
    except BrokenPipeError:
        # whoever reads, such as `head`, has seen enough; nothing is left to flush at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except T2LError as error:
        sys.exit(plain(f"t2l {parsed.command}: {error}"))
    except ModuleNotFoundError as error:
        extra = extra_of(error.name or "")
        if extra is None:
            raise
        sys.exit(
            f"t2l {parsed.command}: {error.name}: not installed; allowed: "
            f"pip install 't2l[{extra}]'"
        )
    # what the system refuses, such as a path that is too long
    except OSError as error:
        named = f"{error.filename}: " if error.filename else ""
        sys.exit(plain(f"t2l {parsed.command}: {named}{error.strerror or error}"))
    except MemoryError:
        sys.exit(f"t2l {parsed.command}: not enough memory for recordings of this size")
    except KeyboardInterrupt:
        print(f"\n{interrupted}", file=sys.stderr)
        sys.exit(STATUS)
