"""``t2l import-csv``: recordings from CSV files with columns and units of their own."""

import argparse

from t2l.cli.mapped import add_mapped, import_mapped

HELP = "make recordings of CSV files whose columns and units a mapping explains"

DESCRIPTION = """\
Make recordings of CSV files with columns and units of their own. A mapping (YAML) says what every
column of the recording comes from, and what a recording's YAML would say; examples/csv_mapping.yaml
is one to start from. Several tables share one mapping.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    add_mapped(parser, DESCRIPTION, "TABLE.csv")


def run(arguments: argparse.Namespace) -> None:
    """See `import_mapped`."""
    from t2l.recordings.importers import read_mapped, read_mapping

    import_mapped(arguments, read_mapping, read_mapped)
