"""What is made of the models is there, is up to date and says what they say."""

import pytest
import yaml
from jsonschema import Draft202012Validator

from t2l.config import document
from tests.conftest import ROOT, configuration

FILES = [ROOT / "config/config.yaml", *sorted((ROOT / "config/studies").glob("*.yaml"))]


def test_the_schema_is_up_to_date():
    assert (ROOT / document.SCHEMA).read_text() == document.schema_text(), "run `make docs`"


def test_the_table_of_keys_is_up_to_date():
    page = (ROOT / document.PAGE).read_text()
    assert page == document.with_table(page), "run `make docs`"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_editors_find_the_schema_and_accept_what_ships(path):
    first = path.read_text().splitlines()[0]
    mark = "# yaml-language-server: $schema="
    assert first.startswith(mark)
    assert (path.parent / first.removeprefix(mark)).resolve() == ROOT / document.SCHEMA
    validator = Draft202012Validator(document.schema())
    assert not list(validator.iter_errors(yaml.safe_load(path.read_text())))


@pytest.mark.parametrize(
    ("section", "keys"),
    [
        ("grid", {"kp": [0, 1]}),
        ("grid", {"kpp": [1]}),
        ("training", {"epochs": 1.5}),
        ("training", {"learning_rate": 11}),
        ("retargeting", {"hold": "median"}),
        ("tuning", {"reward_weights": {"position": [1]}}),
        ("sim_to_real", {"conditions": [{"name": "a"}]}),
        ("robot", {"address": None}),
    ],
)
def test_editors_mark_what_the_models_refuse(section, keys):
    validator = Draft202012Validator(document.schema())
    config = configuration("config")
    assert validator.is_valid(config)
    config[section].update(keys)
    assert not validator.is_valid(config)


def test_every_key_is_explained_with_its_default():
    schema = document.schema()
    models = [schema, *schema["$defs"].values()]
    for model in models:
        for name, field in model["properties"].items():
            assert field.get("description"), name
    table = document.table()
    assert "| `grid.kp` | `[32, 128, 512, 2048]` | list of 1 to 100: number from 1e-06 up" in table
    assert "| `sim_to_real.conditions[].randomisation` | `0.0` | number from 0, below 1 |" in table
