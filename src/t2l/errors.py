"""Errors that a user can cause: each message says where, what was found, what is allowed."""

from pathlib import Path


class T2LError(Exception):
    """Base of every error whose message is meant for the person running t2l."""


class ConfigurationError(T2LError):
    """A configuration key holds something that cannot be run."""


class ArtefactError(T2LError):
    """A file in results/ is truncated, foreign or of another shape than its stage writes."""

    def __init__(self, path: Path | str, found: str, expected: str):
        super().__init__(
            f"{path}: {found}; expected {expected}. Delete it and run snakemake again: only it "
            "and what depends on it are rebuilt."
        )


class ReplayError(T2LError):
    """Too few retargeted demonstrations succeed in a cell to train on."""


class ExpertError(T2LError):
    """The expert did not reach the wanted number of successful demonstrations."""


class RecordingError(T2LError):
    """A recording, or what is to become one, holds something that cannot be used."""

    def __init__(self, path: Path | str, where: str, found: str, allowed: str):
        super().__init__(f"{path}: {where}: found {found}; allowed: {allowed}")
        self.path, self.where, self.found, self.allowed = path, where, found, allowed
