"""Random scenes for fuzzing: documents drawn from the published schema, most of them right, some with mutations."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from random import Random
from typing import Any

import yaml
from scene_files import TETRAHEDRON

from closecall.formats.scene.schema import schema

SCHEMA = schema()
NAMES = ("a", "b", "c", "gear", "é")
WORDS = {
    "parent": NAMES,
    "groups": ("g", "h", "drive"),
    "between": (*NAMES, "*", "*", "[a-z]*", "?*", "[!x]*"),
    "mesh": ("m", "n"),
    "name": ("home", "reach", "grip"),
    "file": ("m.obj", "open.obj", "flat.obj", "path.csv", "path.tum", "turn.csv", "path.euroc", "path.kitti"),
    "times": ("times.txt", "path.kitti"),
    "reason": ("bolted together", ""),
    "$schema": ("../closecall.schema.json",),
}
"""What stands in place of any text, by key."""

USUAL = (0.0, 1.0, -1.0, 0.5, 0.25, 2.0, 10.0, 90.0, -90.0, 151.0, 180.0, 360.0, 1e-3, 1 / 3)
EXTREME = (1e15, -1e15, 1e-15, 1e-60, 1e-61, 5e-324, 1e-320, 1e9, -1e9, 1e-9, 1.7e9, 1e12, -0.0, 1 + 2**-52)
WRONG = (
    *(None, True, False, "", "text", "1", [], {}, [0], [[0, 0, 0]], {"t": 0}, 1e16, -1, 0, 1e308, 10**400),
    *("e\u0301", "world", "g", "x*", "geer", "a/b", "bad.obj", "m.ply", "none.stl", "bad.csv", "m.step", "../m.obj"),
    *(
        "/dev/zero",
        ".",
        "a\0b",
        "x" * 300,
        "http://a.b/m.obj",
        "deep/er/m.obj",
        "\u202e",
        "\x7f",
        "a\nb",
        "x" * 1000,
        {"type": "limits"},
        {"sphere": 1, "box": [1, 1, 1]},
        [0] * 50,
    ),
)
AXES = ([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -2], [1, 1, 0], [1, 2, 3], [1, 0, 1e-7], [1e-60, 0, 0])
QUATERNIONS = ([1, 0, 0, 0], [0, 0, 0, 1], [0.6, 0, 0.8, 0], [0, 0.6, 0, 0.8], [0.5, 0.5, 0.5, 0.5], [-1, 0, 0, 0])
MATRICES = (
    [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    [[0, -1, 0, 0], [1, 0, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]],
    [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
)
SPLINTERS = (
    *"{}[]:,-#&*!|>'\"%@`?~\t\n\0\\ ",
    *("- ", ": ", "null", "true", "1e400", ".nan", "0", "-1", "1e-320", "9" * 400, "{}", "[]", "\u202e", "\ud800"),
    *("world", "keyframes", "orbit", "gear", "matrix", "quat_wxyz", "../", "/dev/zero", "m.obj", "[0, 0, 0]", "<<: "),
    *("&x [*x]", "--- \n", "...", "%YAML 1.1\n", "!!python/object:os.system", "{" * 70, "? ", "|\n", ">-\n", "\ufeff"),
)


def write_files(folder: Path) -> None:
    """Write the files that drawn scenes name."""
    (folder / "m.obj").write_text(TETRAHEDRON)
    (folder / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 1\n")
    (folder / "flat.obj").write_text("v 5 5 5\nf 1 1 1\n")
    (folder / "bad.obj").write_text("v 0 0 0\nv 0 nan 0\n")
    (folder / "m.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 1\nend_header\n")
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0,0\n0.5,1,2,3\n2,0,0,0\n")
    (folder / "path.tum").write_text("0 0 0 0 0 0 0 1\n1e-3 1 1 1 0 0 0.6 0.8\n30 0 0 0 0 0 0 1\n")
    (folder / "turn.csv").write_text("t,x,y,z,roll,pitch,yaw\n0,0,0,0,0,0,0\n5,1e15,0,0,180,0,0\n")
    (folder / "path.euroc").write_text("1000000000,0,0,0,1,0,0,0\n1000000000,0,0,9,1,0,0,0\n3000000000,1,1,1,0,1,0,0\n")
    (folder / "path.kitti").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 0 1 0 0 0 0 0 1 0\n")
    (folder / "times.txt").write_text("0.0\n30\n")
    (folder / "bad.csv").write_text("t,x,y,z\n0,0,0\n")
    (folder / "m.step").write_text("ISO-10303-21;\n")


class _WithoutAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


def drawn_document(source: Random) -> Any:
    """Return a scene as JSON's values: grammatical, and with a few mutations in every other case."""
    document = _drawn(source, SCHEMA, "")
    if source.random() < 0.9:
        _mend_references(source, document)
    for _ in range(source.choice((0, 0, 0, 0, 1, 1, 2, 5))):
        _mutate(source, document)
    return document


def drawn_text(source: Random) -> tuple[str, str]:
    """Return a scene's text and the name of its file; the text of some has been mangled."""
    document = drawn_document(source)
    kind = source.choice(("json", "flow", "block"))
    if kind == "block":
        text = yaml.dump(document, Dumper=_WithoutAliases, allow_unicode=True, sort_keys=False)
    else:
        text = json.dumps(document, ensure_ascii=False, indent=source.choice((None, 1)))
    if source.random() < 0.2:
        text = mangled(source, text)
    return text, "scene.json" if kind == "json" else "scene.yaml"


def mangled(source: Random, text: str) -> str:
    """Return the text with a few characters, words or lines removed, doubled, swapped or replaced."""
    for _ in range(source.randint(1, 4)):
        a, b = sorted(source.randrange(len(text) + 1) for _ in range(2))
        b = min(b, a + source.choice((1, 2, 8, 40)))
        pieces = ("", text[a:b] * 2, source.choice(SPLINTERS), text[a:b][::-1], chr(source.randrange(0x300)))
        text = text[:a] + source.choice(pieces) + text[b:]
    return text


def _drawn(source: Random, part: dict[str, Any], key: str) -> Any:
    """Return a value that a part of the schema allows, under a key."""
    if "$ref" in part:
        return _drawn(source, SCHEMA["$defs"][part["$ref"].rsplit("/", 1)[1]], key)
    if "oneOf" in part:
        return _drawn(source, source.choice(part["oneOf"]), key)
    if "const" in part:
        return part["const"]
    if "enum" in part:
        return source.choice(part["enum"])
    match part["type"]:
        case "object" if "properties" in part:
            return _mapping(source, part)
        case "object":
            names = WORDS["mesh"] if key == "meshes" else NAMES
            chosen = source.sample(names, source.randint(1, len(names)))
            return {name: _drawn(source, part["additionalProperties"], name) for name in chosen}
        case "array":
            return _sequence(source, part, key)
        case "string":
            return source.choice(WORDS[key])
        case "boolean":
            return source.choice((True, False))
        case "number":
            return _number(source, part)
    raise AssertionError(part)


def _mend_references(source: Random, document: dict[str, Any]) -> None:
    """Make most references name something that is there, and most parents stand before their children."""
    bodies = list(document["bodies"])
    for index, body in enumerate(document["bodies"].values()):
        if "parent" in body:
            body["parent"] = bodies[index - 1]
        if index == 0:
            body.pop("parent", None)
    mesh = {"file": "m.obj", "units": "m"}
    document["meshes"] = {"m": mesh, "n": mesh} | document.get("meshes", {})
    if len(bodies) < 2:
        document.pop("pairs", None)
    for section in ("ignore", "check", "margins"):
        for rule in document.get("pairs", {}).get(section, ()):
            rule["between"] = source.sample((*bodies, "*", "?*", "[a-zé]*"), 2)


def _mapping(source: Random, part: dict[str, Any]) -> dict[str, Any]:
    required = part.get("required", ())
    chosen: dict[str, Any] = {
        key: _drawn(source, inner, key)
        for key, inner in part["properties"].items()
        if key in required or source.random() < 0.4
    }
    if part["title"] == "MeshReference":
        chosen["file"] = source.choice(("m.obj", "open.obj", "flat.obj"))
    if part["title"] == "FileMotion":
        chosen["file"] = source.choice(("path.tum",) if chosen["layout"] == "tum" else ("path.csv", "turn.csv"))
    if part["title"] in ("Pose", "Key"):
        rotations = [key for key in chosen if key in ("quat_wxyz", "quat_xyzw", "rpy", "axis_angle", "matrix")]
        for key in rotations[1:]:
            del chosen[key]
        if "matrix" in chosen:
            chosen.pop("xyz", None)
    if part["title"] == "TimeRange" and source.random() < 0.9:
        chosen = {"start": 0.0, "end": source.choice((1.0, 1.0, 2.0, 30.0, 1e6))}
    if "keys" in chosen and source.random() < 0.9:
        times = sorted(source.sample((-1.0, -1e-9, 0.0, 1e-60, 1e-9, 0.3, 0.5, 1.0, 30.0, 1e6, 1e12, 1e15), 4))
        for frame, time in zip(chosen["keys"], times, strict=False):
            frame["t"] = time
        speeds = source.random() < 0.5
        for frame in chosen["keys"]:
            frame.pop("velocity", None)
            if speeds and chosen.get("interpolation", {}).get("translation") == "cubic":
                frame["velocity"] = [_number(source, {"minimum": -1e15}) for _ in range(3)]
    if "exists" in chosen and source.random() < 0.8:
        chosen["exists"] = [source.choice((-1.0, 0.0, 0.25)), source.choice((0.5, 1.0, 1e6))]
    if part["title"] == "ProfileMotion" and chosen["kind"] == "slide":
        chosen.pop("point", None)
    if part["title"] == "OrbitMotion" and source.random() < 0.8:
        chosen |= {"axis": [0, 0, 3], "start": [1, 2, 1e-8]}
    if part["title"] == "BodyPart" and source.random() < 0.7:
        chosen.pop("parent", None)
    if "before" in part["properties"] and source.random() < 0.7:
        chosen |= {"before": source.choice(("hold", "loop")), "after": source.choice(("hold", "loop"))}
    return chosen


def _sequence(source: Random, part: dict[str, Any], key: str) -> list[Any]:
    if key in ("axis", "direction", "start") and source.random() < 0.95:
        return list(source.choice(AXES))
    if key.startswith("quat") and source.random() < 0.95:
        return list(source.choice(QUATERNIONS))
    if key == "matrix" and source.random() < 0.95:
        return [list(row) for row in source.choice(MATRICES)]
    if "prefixItems" in part:
        return [_drawn(source, inner, key) for inner in part["prefixItems"]]
    count = source.randint(part.get("minItems", 0), source.choice((1, 2, 4, min(20, part.get("maxItems", 4)))))
    return [_drawn(source, part["items"], key) for _ in range(max(count, part.get("minItems", 0)))]


def _number(source: Random, part: dict[str, Any]) -> float:
    least = part.get("minimum", -1e15)
    pool = EXTREME if source.random() < 0.1 else USUAL
    most = part.get("exclusiveMaximum", float("inf"))
    fitting = [value for value in pool if least <= value < most]
    return source.choice(fitting or [value for value in USUAL if least <= value < most])


def _mutate(source: Random, document: Any) -> None:
    """Replace, remove, rename, double or swap one value somewhere in a document."""
    places: list[tuple[Any, Any]] = []
    waiting = [document]
    while waiting:
        value = waiting.pop()
        items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, inner in items:
            places.append((value, key))
            waiting.append(inner)
    if not places:
        return
    owner, key = source.choice(places)
    match source.randrange(5):
        case 0:
            owner[key] = deepcopy(source.choice(WRONG))  # what comes next may change it
        case 1:
            del owner[key]
        case 2 if isinstance(owner, dict):
            owner[mangled(source, key)] = owner.pop(key)
        case 3:
            other, place = source.choice(places)
            owner[key] = json.loads(json.dumps(other[place])) if place in _keys(other) else None
        case _:
            owner[key] = source.choice(EXTREME + USUAL)


def _keys(value: Any) -> Any:
    return value if isinstance(value, dict) else range(len(value))
