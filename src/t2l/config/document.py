"""What is made of the configuration's models: a JSON schema for editors, and the table of keys.

`python -m t2l.config.document` writes both into `config/` of the working directory.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from t2l.artefacts import write_text
from t2l.config.models import Configuration
from t2l.config.training import cloned
from t2l.policies import POLICIES

SCHEMA, PAGE = Path("config/schema.json"), Path("config/README.md")
BEGIN, END = "<!-- keys: made by `make docs` -->\n", "<!-- end of keys -->\n"
# pydantic leaves bounds of unions as they are
BOUNDS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "lt": "exclusiveMaximum",
}
NUMBER = [{"type": "integer"}, {"type": "number"}]
NOTHING = {"type": "null"}


def schema() -> dict[str, Any]:
    """The JSON schema of a configuration file, with the keys of every policy that is cloned."""
    made = _plain(Configuration.model_json_schema())
    training = made["$defs"]["Training"]["properties"]
    # the library's: a user's own stand with the user
    for name in (name for name in cloned() if name in POLICIES.known):
        own = _plain(POLICIES.find(name).settings.model_json_schema())["properties"]
        for key, field in own.items():
            said = f"of `{name}`: {field['description']}"
            known = training.setdefault(key, {**field, "description": said})
            if known["default"] != field["default"]:
                known["description"] += f"; {_in_yaml(field['default'])} for `{name}`"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made}


def table() -> str:
    """A Markdown table: each key with its default, what it may hold and what it means."""
    rows = "".join(f"{row}\n" for row in _rows(schema()))
    return f"| key | default | allowed | meaning |\n|---|---|---|---|\n{rows}"


def with_table(page: str) -> str:
    """A page with the table between its marks.

    Raises:
        ValueError: the page has no such marks.
    """
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n{table()}\n{END}{after}"


def schema_text() -> str:
    """The content of the file of the schema."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def _plain(node: Any) -> Any:
    """A schema by pydantic in the words of JSON Schema, and without what tells nothing."""
    if isinstance(node, list):
        return [_plain(part) for part in node]
    if not isinstance(node, dict):
        return node
    plain = {BOUNDS.get(key, key): _plain(value) for key, value in node.items()}
    if not isinstance(plain.get("title"), dict):
        plain.pop("title", None)
    match plain.get("anyOf"):
        case [given, nothing] if nothing == NOTHING:
            del plain["anyOf"], plain["default"]
            plain = {**given, **plain}
        case kinds if kinds == NUMBER:
            del plain["anyOf"]
            plain = {"type": "number", **plain}
    return plain


def _rows(whole: Mapping[str, Any]) -> Iterator[str]:
    for name, field in whole["properties"].items():
        section = _section(field, whole)
        if section is None:
            yield _row(name, field, name in whole["required"])
            continue
        yield f"| **`{name}`** | | | {field['description']} |"
        yield from _keys(name, section, whole)


def _keys(prefix: str, section: Mapping[str, Any], whole: Mapping[str, Any]) -> Iterator[str]:
    for name, field in section["properties"].items():
        key = f"{prefix}.{name}"
        yield _row(key, field, name in section.get("required", []))
        entry = _section(field.get("items", {}), whole)
        if entry is not None:
            yield from _keys(f"{key}[]", entry, whole)


def _section(field: Mapping[str, Any], whole: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The section that a key holds, if it does."""
    if "$ref" not in field:
        return None
    return whole["$defs"][field["$ref"].rpartition("/")[2]]


def _row(key: str, field: Mapping[str, Any], required: bool) -> str:
    if "default" in field:
        default = f"`{_in_yaml(field['default'])}`"
    else:
        default = "to be given" if required else ""
    return f"| `{key}` | {default} | {_allowed(field)} | {field['description']} |"


def _in_yaml(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=1000)
    return text.removesuffix("\n").removesuffix("\n...")


def _allowed(field: Mapping[str, Any]) -> str:
    if "enum" in field:
        return ", ".join(f"`{value}`" for value in field["enum"])
    match field.get("type"):
        case "array":
            least, most = field.get("minItems", 0), field["maxItems"]
            count = f"{most}" if least == most else f"{least} to {most}"
            return f"list of {count}: {_allowed(field['items'])}"
        case "object":
            return f"names, each with a {_allowed(field['additionalProperties'])}"
        case "integer":
            return f"whole number{_bounds(field)}"
        case "number":
            return f"number{_bounds(field)}"
        case "string":
            return "text"
    return "keys below"


def _bounds(field: Mapping[str, Any]) -> str:
    if "minimum" in field:
        words = f" from {field['minimum']}"
    else:
        words = f" above {field['exclusiveMinimum']}" if "exclusiveMinimum" in field else ""
    if "maximum" in field:
        return f"{words} up to {field['maximum']}"
    return f"{words}, below {field['exclusiveMaximum']}" if "exclusiveMaximum" in field else words


if __name__ == "__main__":
    write_text(schema_text(), SCHEMA)
    write_text(with_table(PAGE.read_text()), PAGE)
