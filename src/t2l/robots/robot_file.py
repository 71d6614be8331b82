"""What the file of a robot says, looked at before MuJoCo reads it.

MuJoCo passes over much that makes another robot: limits the wrong way round leave a joint
unlimited, NaN becomes zero, what only xacro understands is left out.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from t2l.errors import InputError
from t2l.typed import LARGEST

# format: numbers of a URDF's elements by attribute, https://wiki.ros.org/urdf/XML
URDF_NUMBERS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "mass": {"value": 1},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), 1),
    "dynamics": {"damping": 1, "friction": 1},
    "mimic": {"multiplier": 1, "offset": 1},
}
NOT_NEGATIVE = ("value", "effort", "velocity", "damping", "friction")
LIMITED = ("revolute", "prismatic")
WITH_AXIS = (*LIMITED, "continuous", "planar")
XACRO = "xacro"
# numerics: of the sum of two principal moments, beyond which a third is no rounding
ROUNDING = 1e-6
PIXELS, ROWS, COPIES = ("width", "height"), ("nrow", "ncol"), ("count",)
SIZES = {"texture": PIXELS, "hfield": ROWS, "replicate": COPIES, "composite": COPIES}
# bound: of pictures, of a height field and of bodies, ten times what robots and scenes have
MOST = {PIXELS: 1e8, ROWS: 1e7, COPIES: 1e4, (): np.inf}


def parsed(path: Path) -> ElementTree.Element:
    """The root of an XML file.

    Raises:
        InputError: it is none that an XML parser reads, or one that xacro has still to expand.
    """
    namespace = None
    try:
        with open(path, "rb") as file:
            events = ElementTree.iterparse(file, events=("start", "start-ns"))
            for event, found in events:
                if event == "start-ns":
                    namespace = found[1] if found[0] == XACRO else namespace
                elif unexpanded := _of_xacro(found, namespace):
                    raise _xacro(path, unexpanded)
            return events.root
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        if f"<{XACRO}:".encode() in path.read_bytes():
            raise _xacro(path, f"<{XACRO}:…>") from None
        allowed = "well-formed XML"
        raise InputError(path, "its text", f"no XML that can be read ({error})", allowed) from None


def check(path: Path, root: ElementTree.Element) -> None:
    """Find what MuJoCo would take for something else.

    Args:
        path: of the file, for messages.
        root: of an MJCF, of a file that it includes, or of a URDF.

    Raises:
        InputError: naming element and attribute.
    """
    named = {element.get(key) for element in root.iter() for key in ("name", "class")}
    try:
        elements = list(_elements(root))
    except RecursionError:
        raise InputError(path, "its elements", "too many levels", "fewer") from None
    for element, place in elements:
        for key, text in element.attrib.items():
            if text not in named:
                _check_numbers(path, f"{place}, attribute {key}", _tag(element), key, text)
    _check_sizes(path, root)
    if root.tag == "robot":
        _check_urdf(path, root)


def _check_sizes(path: Path, root: ElementTree.Element) -> None:
    """What takes more memory than any robot, as MuJoCo builds it before it looks at it."""
    for element in root.iter():
        keys = SIZES.get(_tag(element), ())
        words = " ".join(element.get(key, "") for key in keys).split()
        try:
            size = float(np.prod([float(word) for word in words]))
        except ValueError:
            continue  # MuJoCo says so
        if size > MOST[keys]:
            where = f"<{_tag(element)}>, attribute {' and '.join(keys)}"
            raise InputError(path, where, f"{size:.3g} in all", f"at most {MOST[keys]:.0f}")


def _of_xacro(element: ElementTree.Element, namespace: str | None) -> str:
    """What of an element only xacro understands; "" if nothing."""
    if namespace is not None and element.tag.startswith(f"{{{namespace}}}"):
        return f"<{XACRO}:{_tag(element)}>"
    texts = [text for text in element.attrib.values() if "${" in text or "$(" in text]
    return repr(texts[0]) if texts else ""


def _xacro(path: Path, found: str) -> InputError:
    return InputError(
        path, "its elements", f"{found}, as it is a xacro", f"what `xacro {path.name}` makes of it"
    )


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rsplit("}", 1)[-1]


def _elements(
    element: ElementTree.Element, owner: str = ""
) -> Iterator[tuple[ElementTree.Element, str]]:
    """Every element, and where it is: its tag and the nearest name above it.

    What stands in <custom> is anybody's.
    """
    tag, name = _tag(element), element.get("name")
    yield element, f"{tag} {name}" if name else f"<{tag}>{owner and f' of {owner}'}"
    if tag != "custom":
        for inside in element:
            yield from _elements(inside, f"{tag} {name}" if name else owner)


def _check_numbers(path: Path, place: str, tag: str, key: str, text: str) -> None:
    """Whether numbers are of a possible size, and ranges the right way round."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return
    # no limit is a limit that is infinite
    limit = tag == "limit" or key.endswith("range")
    if any(np.isnan(n) or (abs(n) > LARGEST and not limit) for n in numbers):
        raise InputError(path, place, repr(text), f"finite numbers up to {LARGEST:g}")
    if key.endswith("range") and len(numbers) == 2 and numbers[0] > numbers[1]:
        raise InputError(path, place, repr(text), "the lower limit before the upper")


def _check_urdf(path: Path, root: ElementTree.Element) -> None:
    for kind in ("link", "joint"):
        names = set()
        for element in root.findall(kind):
            name = element.get("name", "")
            if not name.strip():
                raise InputError(path, f"a <{kind}>", "no name", "a name for each")
            if name in names:
                raise InputError(path, f"{kind} {name}", "it twice", "names that differ")
            names.add(name)
            for inside in element.iter():
                _check_urdf_numbers(path, f"<{inside.tag}> of {kind} {name}", inside)
    for link in root.findall("link"):
        _check_inertia(path, link)
    for joint in root.findall("joint"):
        _check_joint(path, joint)


def _check_urdf_numbers(path: Path, place: str, element: ElementTree.Element) -> None:
    for key, count in URDF_NUMBERS.get(element.tag, {}).items():
        text = element.get(key)
        if text is None:
            continue
        where = f"{place}, attribute {key}"
        allowed = "a number" if count == 1 else f"{count} numbers"
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            raise InputError(path, where, repr(text), allowed) from None
        if len(numbers) != count:
            raise InputError(path, where, repr(text), allowed)
        if key in NOT_NEGATIVE and numbers[0] < 0:
            raise InputError(path, where, text, "0 or more")


def _check_joint(path: Path, joint: ElementTree.Element) -> None:
    kind, name = joint.get("type"), joint.get("name")
    limit, axis = joint.find("limit"), joint.find("axis")
    if kind in LIMITED and limit is not None:
        lower, upper = limit.get("lower", "0"), limit.get("upper", "0")
        # MuJoCo takes either for no limit; 0 and 0 is what exporters write who know none
        if float(lower) > float(upper) or float(lower) == float(upper) != 0:
            raise InputError(
                path, f"joint {name}, attributes lower and upper of <limit>",
                f"{lower} and {upper}", "lower below upper, or both 0 for no limit",
            )  # fmt: skip
    direction = axis.get("xyz", "1 0 0") if axis is not None else "1 0 0"
    if kind in WITH_AXIS and not any(map(float, direction.split())):
        raise InputError(path, f"joint {name}, attribute xyz of <axis>", direction, "a direction")


def _check_inertia(path: Path, link: ElementTree.Element) -> None:
    """Whether a body can have the inertia.

    About principal axes Ixx + Iyy − Izz = 2 ∫ z² dm, which is not negative, and likewise in turn.
    """
    found = link.find("inertial/inertia")
    if found is None:
        return
    missing = [key for key in URDF_NUMBERS["inertia"] if key not in found.attrib]
    if missing:
        raise InputError(
            path, f"<inertia> of link {link.get('name')}", f"no {', '.join(missing)}",
            ", ".join(URDF_NUMBERS["inertia"]),
        )  # fmt: skip
    xx, xy, xz, yy, yz, zz = (float(found.attrib[key]) for key in URDF_NUMBERS["inertia"])
    moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    most = ROUNDING * abs(moments).max()
    if moments[0] < -most or moments[2] > moments[0] + moments[1] + most:
        shown = ", ".join(f"{moment:.4g}" for moment in moments)
        raise InputError(
            path, f"<inertia> of link {link.get('name')}", f"principal moments {shown} kg·m²",
            "none negative, and none above the sum of the other two, as no body has such",
        )  # fmt: skip
