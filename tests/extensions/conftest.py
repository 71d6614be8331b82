"""Every example of an extension, loaded as a configuration's `extensions` are."""

import pytest

from t2l.registry import load_extensions
from tests.conftest import ROOT


@pytest.fixture(scope="package", autouse=True)
def examples():
    """The folder of the examples, whose classes are known from here on."""
    folder = ROOT / "examples/extensions"
    load_extensions([folder])
    return folder
