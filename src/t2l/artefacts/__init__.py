"""Reading and writing artefacts: whole or not at all, and foreign ones named."""

from t2l.artefacts.reading import (
    checked_file,
    parsing,
    read_arrow,
    read_json,
    read_npz,
    read_table,
    read_text,
    read_yaml,
    reading,
)
from t2l.artefacts.writing import remove, set_aside, whole, write_table, write_text

__all__ = [
    "checked_file",
    "parsing",
    "read_arrow",
    "read_json",
    "read_npz",
    "read_table",
    "read_text",
    "read_yaml",
    "reading",
    "remove",
    "set_aside",
    "whole",
    "write_table",
    "write_text",
]
