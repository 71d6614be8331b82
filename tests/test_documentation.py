import re
from typing import get_args, get_origin

import pytest

from t2l.config.models import Configuration
from t2l.tasks import TASKS
from t2l.typed import Typed
from tests.conftest import ROOT


def _models(kind):
    """The models that an annotation is made of."""
    if isinstance(kind, type) and issubclass(kind, Typed):
        yield kind
    for part in get_args(kind):
        yield from _models(part)


def _keys(model, prefix="", seen=()):
    """Keys of sections too, of each kind of section once; entries of a list go with the list."""
    seen = list(seen)
    for name, field in model.model_fields.items():
        yield prefix + name
        for inner in _models(field.annotation):
            if get_origin(field.annotation) is not list and inner not in seen:
                seen.append(inner)
                yield from _keys(inner, f"{prefix}{name}.", seen)


@pytest.mark.parametrize("model", [Configuration, *(task.parameters for task in TASKS.values())])
def test_every_key_is_explained(model):
    text = (ROOT / "config/README.md").read_text()
    explained = set(re.findall(r"`([a-z_.]+)`", text))
    missing = set(_keys(model)) - explained
    assert not missing, f"{missing} stand in no table of config/README.md"


def test_the_readme_names_files_that_exist():
    text = (ROOT / "README.md").read_text()
    for link in re.findall(r"\]\(([^)#]+)\)", text):
        assert (ROOT / link).exists(), link
