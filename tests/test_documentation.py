import re

import yaml

from tests.conftest import ROOT


def _keys(schema, prefix=""):
    for name, part in schema.get("properties", {}).items():
        yield prefix + name
        yield from _keys(part, f"{prefix}{name}.")


def test_every_key_is_explained():
    text = (ROOT / "config/README.md").read_text()
    explained = set(re.findall(r"`([a-z_.]+)`", text))
    for path in (ROOT / "config/schema").glob("*.schema.yaml"):
        missing = set(_keys(yaml.safe_load(path.read_text()))) - explained
        assert not missing, f"{path.name}: {missing} stand in no table of config/README.md"


def test_the_readme_names_files_that_exist():
    text = (ROOT / "README.md").read_text()
    for link in re.findall(r"\]\(([^)#]+)\)", text):
        assert (ROOT / link).exists(), link
