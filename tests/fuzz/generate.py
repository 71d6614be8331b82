"""Documents drawn from the typed models, and what is wrong with most of them."""

import copy
import json
from typing import Any

import yaml
from hypothesis import strategies as st
from pydantic import BaseModel

# what people, other programs and bad luck put where something else belongs
FOREIGN = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 3),
    st.sampled_from([0, -1, 1e-300, -1e-300, 1e300, 1e9, 10**18, 10**400, 2**63, 0.5, 1.0, 1e-5]),
    st.sampled_from([float("nan"), float("inf"), float("-inf")]),
    st.sampled_from(
        ["", " ", "x", "nan", "1", "../../evil", "/etc/passwd", "x\n", "$\\frac{$", "\0", "é" * 40]
    ),
    st.sampled_from(["n" * 5000, "../" * 100, "simulation", "<script>", "{}", "- a", "yes"]),
    st.lists(st.integers(-1, 3), max_size=3),
    st.just([]),
    st.just({}),
    st.just([[[[1]]]]),
    st.just({"x": {"y": [1, {"z": None}]}}),
    st.just(list(range(2000))),
).map(copy.deepcopy)  # examples change what they draw

# text that is no document of this kind, or one too many
BROKEN_TEXT = (
    "",
    "\t",
    "a: [",
    "a: b: c",
    "- 1\n- 2\n",
    "3",
    "null",
    "--- a\n--- b\n",
    "&a [*a]",
    "x: &x {y: *x}",
    "? [1, 2]\n: 3\n",
    "!!python/object/apply:os.system [touch evil]",
    "\n".join(["a: &a [x, x]", *(f"{b}: &{b} [*{a}, *{a}, *{a}, *{a}]" for a, b in zip(
        "abcdefghijklmnopqrstuvw", "bcdefghijklmnopqrstuvwx", strict=True))]),
    "[" * 5000,
    "{a: " * 200,
    "x: " + "9" * 6000,
    "- " * 3000,
    "#" * 1_200_000,
)  # fmt: skip
BROKEN_BYTES = (b"\xff\xfe", b"\x00" * 20, bytes(range(256)), b"caf\xe9: 1", b"PAR1", b"PK\x03\x04")


def values(model: type[BaseModel]) -> st.SearchStrategy:
    """Values that a typed model's own schema allows; what relates keys may still refuse them."""
    schema = model.model_json_schema(by_alias=True)
    return _of(schema, schema.get("$defs", {}))


def _of(schema: dict[str, Any], defs: dict[str, Any]) -> st.SearchStrategy:
    if "$ref" in schema:
        return _of(defs[schema["$ref"].rsplit("/", 1)[-1]], defs)
    if "anyOf" in schema or "oneOf" in schema:
        return st.one_of([_of(s, defs) for s in schema.get("anyOf", schema.get("oneOf"))])
    if "enum" in schema:
        return st.sampled_from(schema["enum"])
    if "const" in schema:
        return st.just(schema["const"])
    match schema.get("type"):
        case "object" if "properties" in schema:
            required = set(schema.get("required", ()))
            parts = {k: _of(s, defs) for k, s in schema["properties"].items()}
            return st.fixed_dictionaries(
                {k: s for k, s in parts.items() if k in required},
                optional={k: s for k, s in parts.items() if k not in required},
            )
        case "object":
            inside = schema.get("additionalProperties")
            inside = _of(inside, defs) if isinstance(inside, dict) else FOREIGN
            return st.dictionaries(st.sampled_from("abc"), inside, max_size=2)
        case "array":
            few = schema.get("minItems", 0)
            if "prefixItems" in schema:
                return st.tuples(*(_of(s, defs) for s in schema["prefixItems"])).map(list)
            return st.lists(
                _of(schema.get("items", {}), defs),
                min_size=few,
                max_size=min(few + 3, schema.get("maxItems", few + 3)),
            )
        case "integer" | "number":
            low = schema.get("minimum", schema.get("exclusiveMinimum", -1e3))
            high = schema.get("maximum", schema.get("exclusiveMaximum", max(1e3, 2 * abs(low))))
            if schema["type"] == "integer":
                return st.integers(int(low), int(min(high, low + 20)))
            return st.one_of(st.integers(int(low) + 1, int(min(high, low + 20)) + 1),
                             st.floats(low, high))  # fmt: skip
        case "string":
            return st.sampled_from(["x", "fr3", "joint_a", "simulation", "journal", "notes: 1"])
        case "boolean":
            return st.booleans()
        case "null":
            return st.none()
    return FOREIGN


@st.composite
def spoilt(draw, document: dict[str, Any], model: type[BaseModel]) -> dict[str, Any]:
    """A sound document with up to three keys changed: within the schema, or not."""
    document = copy.deepcopy(document)
    for _ in range(draw(st.integers(0, 3))):
        places = [(), *_places(document)]
        *above, last = draw(st.sampled_from(places)) or ("",)
        part: Any = document
        for step in above:
            part = part[step]
        kind = draw(st.sampled_from(["foreign", "own", "remove", "rename", "add"]))
        if kind == "own" and not above:
            own = draw(values(model))
            if last in own:
                document[last] = own[last]
            continue
        if last == "" or kind == "add":
            if isinstance(part, dict):
                name = draw(st.sampled_from(["kpp", "x y", "__class__", "evil", "1"]))
                part[name] = draw(FOREIGN)
        elif kind == "remove":
            del part[last]
        elif kind == "rename" and isinstance(part, dict):
            part[f"{last}s"] = part.pop(last)
        else:
            part[last] = draw(FOREIGN)
    return document


def _places(value: Any, path: tuple = ()) -> list[tuple]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    found = []
    for key, inside in items:
        found.append((*path, key))
        if isinstance(inside, dict | list) and len(inside) < 50:
            found += _places(inside, (*path, key))
    return found


@st.composite
def as_bytes(draw, document: Any, json_too: bool = False) -> bytes:
    """A document as YAML (or JSON), now and then in bytes that no reader expects."""
    try:
        text = yaml.safe_dump(document, allow_unicode=True, sort_keys=False)
    except (yaml.YAMLError, ValueError):  # more digits than Python writes
        text = "a: 1"
    if json_too:
        try:
            text = json.dumps(document)
        except ValueError:
            text = "{}"
    kind = draw(
        st.sampled_from(["sound"] * 12 + ["twice", "cut", "bytes", "text", "coded", "noise"])
    )
    if kind == "twice":
        first = next(iter(document), "robot") if isinstance(document, dict) else "robot"
        return f"{text}\n{first}: 3\n".encode()
    if kind == "cut":
        return text.encode()[: draw(st.integers(0, len(text)))]
    if kind == "bytes":
        return draw(st.sampled_from(BROKEN_BYTES))
    if kind == "text":
        return draw(st.sampled_from(BROKEN_TEXT)).encode()
    if kind == "coded":
        return text.encode(draw(st.sampled_from(["utf-16", "utf-32", "latin-1", "utf-8-sig"])),
                           errors="replace")  # fmt: skip
    if kind == "noise":
        return damaged(draw, text.encode())
    return text.encode(errors="replace")


def damaged(draw, content: bytes) -> bytes:
    """Some bytes replaced by others."""
    content = bytearray(content)
    for _ in range(draw(st.integers(1, 5))):
        if content:
            content[draw(st.integers(0, len(content) - 1))] = draw(st.integers(0, 255))
    return bytes(content)
