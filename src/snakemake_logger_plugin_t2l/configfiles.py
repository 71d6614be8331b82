"""Configuration files read by t2l's one loader of YAML and JSON, in place of Snakemake's.

Snakemake reads files given by `--configfile` before it reads the Snakefile. Its own loader
follows aliases without end and takes the last of repeated keys; nothing in a Snakefile comes early
enough to say so.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from snakemake.common import configfile
from snakemake.exceptions import CliException

PURPOSE = "a configuration, keys with values"

_snakemakes = configfile._load_configfile


def install() -> None:
    """From now on Snakemake loads configuration files with `load`."""
    configfile._load_configfile = load


def load(path_or_file: Any, filetype: str = "Config") -> Any:
    """The content of a configuration file; what is no path is left to Snakemake.

    Raises:
        CliException: naming the file, what was found and what is allowed.
    """
    if not isinstance(path_or_file, str | Path) or filetype != "Config":
        return _snakemakes(path_or_file, filetype)
    from t2l.documents import read_json, read_yaml
    from t2l.errors import InputError

    path = Path(path_or_file)
    read = read_json if path.suffix.lower() == ".json" else read_yaml
    try:
        content = read(path, PURPOSE)
        if not isinstance(content, Mapping):
            found = "nothing" if content is None else f"a {type(content).__name__}"
            raise InputError(path, "the file", found, PURPOSE)
    except InputError as error:
        raise CliException(str(error)) from None
    return content
