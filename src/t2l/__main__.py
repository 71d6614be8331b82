"""``t2l``, as a command and as ``python -m t2l``."""

from t2l.threads import one_thread


def main() -> None:
    """Run the command."""
    one_thread()
    from t2l.cli.main import main as run

    run()


if __name__ == "__main__":
    main()
