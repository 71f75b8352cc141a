"""The JSON Schema: it accepts what the reader accepts, refuses plain mistakes and says what each key is for."""

from __future__ import annotations

import json
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import CliRunner
from places import SAMPLES
from scene_files import HEAD, MOTION, load

from closecall.cli.commands.schema import command
from closecall.formats.scene.schema import schema, schema_text
from closecall.formats.scene.text.errors import SceneError
from closecall.formats.scene.text.source import read_document

DOCS = SAMPLES.parent / "docs"
SCENES = sorted(SAMPLES.glob("*/scene.yaml"))
FIRST_LINE = "# yaml-language-server: $schema=../closecall.schema.json\n"


def listed(value: object) -> Any:
    """Return a document's value with lists instead of tuples."""
    if isinstance(value, dict):
        return {key: listed(inner) for key, inner in value.items()}
    return [listed(inner) for inner in value] if isinstance(value, tuple) else value


def problems(text: str) -> list[str]:
    """Return what the schema finds wrong with a scene in YAML."""
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(schema())
    return [error.message for error in validator.iter_errors(listed(read_document(text.encode(), "s.yaml").value))]


def everything(value: Any) -> Iterator[Any]:
    """Yield a JSON value and all within it."""
    yield value
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    for one in inner:
        yield from everything(one)


def definitions() -> dict[str, Any]:
    made = schema()
    return {made["title"]: made, **made["$defs"]}


def test_the_command_prints_the_committed_file() -> None:
    printed = CliRunner().invoke(command).output
    assert printed == schema_text()
    assert printed == (SAMPLES / "closecall.schema.json").read_text(encoding="utf-8"), (
        "write it anew: closecall schema > sample_scenes/closecall.schema.json"
    )


def test_it_is_a_schema() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(schema())
    assert schema()["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@pytest.mark.parametrize("path", SCENES, ids=[path.parent.name for path in SCENES])
def test_every_sample_is_valid_by_the_schema_that_its_first_line_shows_to_editors(path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    text = path.read_text(encoding="utf-8")
    assert text.startswith(FIRST_LINE)
    shown = json.loads((path.parent / FIRST_LINE.partition("$schema=")[2].strip()).read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(shown).validate(yaml.safe_load(text))


def test_a_sample_as_json_names_the_schema_as_a_key() -> None:
    assert problems('$schema: "../closecall.schema.json"\n' + HEAD + "bodies: {}") == []


def test_every_key_says_what_it_is_for() -> None:
    for title, definition in definitions().items():
        assert definition["description"], title
        for key, field in definition["properties"].items():
            assert field.get("description", "").partition("Default: ")[0], (title, key)


def test_every_key_that_may_be_left_out_says_its_default() -> None:
    for title, definition in definitions().items():
        for key, field in definition["properties"].items():
            if key not in definition.get("required", ()):
                assert "default" in field or "Default: " in field["description"], (title, key)


UNITS = re.compile(
    "length unit|angle unit|that unit|same unit|[Ss]econds|[Dd]irection|[Ff]actor|share|Unit quaternion|version",
    re.IGNORECASE,
)
"""What a number may be said to be in."""


def test_every_number_says_its_unit() -> None:
    for title, definition in definitions().items():
        for key, field in definition["properties"].items():
            if any(isinstance(one, dict) and one.get("type") == "number" for one in everything(field)):
                assert UNITS.search(field["description"]), (title, key)


def test_the_reference_is_what_is_generated_now() -> None:
    made = runpy.run_path(str(DOCS / "make_reference.py"))["reference"]()
    assert (DOCS / "scene_reference.md").read_text(encoding="utf-8") == made, "write it anew: docs/make_reference.py"


def test_the_reference_has_every_key_of_every_mapping() -> None:
    sections = (DOCS / "scene_reference.md").read_text(encoding="utf-8").split("\n## ")[1:]
    shown = {section.split("\n")[0]: re.findall(r"^\| `([^`]+)` \|", section, re.M) for section in sections}
    kept = {title.removesuffix("Part"): sorted(one["properties"]) for title, one in definitions().items()}
    assert {title: sorted(keys) for title, keys in shown.items()} == kept


def test_nothing_may_be_null_nor_is_by_default() -> None:
    for value in everything(schema()):
        assert value is not None
        assert value != "null"


def test_a_default_that_is_written_out_changes_nothing(tmp_path: Path) -> None:
    defaults = {
        key: field["default"] for key, field in definitions()["SceneFile"]["properties"].items() if "default" in field
    }
    assert set(defaults) == {"settings", "pairs"}
    body = {
        key: field["default"] for key, field in definitions()["BodyPart"]["properties"].items() if "default" in field
    }
    assert set(body) == {"pose", "shapes", "groups"}
    written = f"{HEAD}bodies: {{a: {json.dumps(body)}}}\n" + "".join(
        f"{key}: {json.dumps(value)}\n" for key, value in defaults.items()
    )
    one, other = load(tmp_path, written), load(tmp_path, f"{HEAD}bodies: {{a: {{}}}}\n")
    assert (one.settings, one.scene.rules) == (other.settings, other.scene.rules)
    assert (one.scene.bodies[0].pose == other.scene.bodies[0].pose).all()


GOOD_MOTION = "{type: keyframes, keys: [{t: 0}, {t: 1}]}"


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (HEAD + "bodies: {}", HEAD + "bodis: {}"),
        (HEAD + "bodies: {}", HEAD),
        (HEAD + "bodies: {}", HEAD.replace("closecall: 1", "closecall: 2") + "bodies: {}"),
        (HEAD + "bodies: {}", HEAD.replace("mm", "km") + "bodies: {}"),
        (HEAD + "bodies: {}", HEAD.replace(", angle: deg", "") + "bodies: {}"),
        (HEAD + "bodies: {}", HEAD.replace("end: 1", "end: '1'") + "bodies: {}"),
        (HEAD + "bodies: {}", HEAD + "bodies: []"),
        (HEAD + "settings: {margin: 0}\nbodies: {}", HEAD + "settings: {margin: -1}\nbodies: {}"),
        (HEAD + "bodies: {a: {shapes: [{sphere: 1}]}}", HEAD + "bodies: {a: {shapes: [{sphere: 0}]}}"),
        (HEAD + "bodies: {a: {shapes: [{sphere: 1}]}}", HEAD + "bodies: {a: {shapes: [{sphre: 1}]}}"),
        (HEAD + "bodies: {a: {shapes: [{sphere: 1}]}}", HEAD + "bodies: {a: {shapes: [{sphere: 1, box: [1, 1, 1]}]}}"),
        (HEAD + "bodies: {a: {shapes: [{box: [1, 1, 1]}]}}", HEAD + "bodies: {a: {shapes: [{box: [1, 1]}]}}"),
        (HEAD + "bodies: {a: {shapes: [{ellipsoid: [1, 1, 1]}]}}", HEAD + "bodies: {a: {shapes: [{ellipsoid: 1}]}}"),
        (
            HEAD + "bodies: {a: {shapes: [{mesh: m, scale: [1, 2, 3]}]}}",
            HEAD + "bodies: {a: {shapes: [{mesh: m, scale: [1, 2]}]}}",
        ),
        (HEAD + "bodies: {a: {pose: {xyz: [1, 2, 3]}}}", HEAD + "bodies: {a: {pose: {xyz: [1, 2, 3, 4]}}}"),
        (HEAD + "bodies: {a: {pose: {rpy: [1, 2, 3]}}}", HEAD + "bodies: {a: {pose: {quat: [1, 0, 0, 0]}}}"),
        (
            HEAD + "bodies: {a: {pose: {rpy: [1, 2, 3]}}}",
            HEAD + "bodies: {a: {pose: {rpy: [1, 2, 3], quat_wxyz: [1, 0, 0, 0]}}}",
        ),
        (HEAD + "bodies: {a: {exists: [0, 1]}}", HEAD + "bodies: {a: {exists: [0]}}"),
        (MOTION + GOOD_MOTION, MOTION + GOOD_MOTION.replace("keyframes", "keyframe")),
        (MOTION + GOOD_MOTION, MOTION + GOOD_MOTION.replace("{t: 1}", "{t: 1, names: a}")),
        (MOTION + GOOD_MOTION, MOTION + GOOD_MOTION.replace("[{t: 0}, {t: 1}]", "[]")),
        (MOTION + GOOD_MOTION, MOTION + GOOD_MOTION.replace("keys", "before: stay, keys")),
        (MOTION + GOOD_MOTION, MOTION + GOOD_MOTION.replace("keys", "interpolation: {rotation: lerp}, keys")),
        (
            MOTION + "{type: file, file: a.csv, layout: csv, max_gap: 1}",
            MOTION + "{type: file, file: a.csv, layout: csv, max_gap: 0}",
        ),
        (MOTION + "{type: file, file: a.csv, layout: csv}", MOTION + "{type: file, file: a.csv, layout: ros}"),
        (
            HEAD + "bodies: {}\npairs: {margins: [{between: [a, b], margin: 1}]}",
            HEAD + "bodies: {}\npairs: {margins: [{between: [a, b]}]}",
        ),
        (
            HEAD + "bodies: {}\npairs: {ignore: [{between: [a, b], reason: r}]}",
            HEAD + "bodies: {}\npairs: {ignore: [{between: [a, b, c], reason: r}]}",
        ),
        (HEAD + "bodies: {}\npairs: {default: ignore}", HEAD + "bodies: {}\npairs: {default: maybe}"),
    ],
)
def test_a_plain_mistake_is_refused(tmp_path: Path, right: str, wrong: str) -> None:
    assert problems(right) == []
    assert problems(wrong)
    with pytest.raises(SceneError):
        load(tmp_path, wrong)
