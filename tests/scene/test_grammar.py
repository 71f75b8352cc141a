"""What the grammar refuses, and in which words: one line a fault, at its key or value."""

from __future__ import annotations

import pytest

from closecall.formats.scene.grammar.scene import SceneFile
from closecall.formats.scene.grammar.wording import parsed
from closecall.formats.scene.text.errors import SceneError
from closecall.formats.scene.text.source import read_document

HEAD = "closecall: 1\nunits: {length: m, angle: deg}\ntime: {start: 0, end: 1}\n"
JSON_REST = '"units": {"length": "m", "angle": "deg"}, "time": {"start": 0, "end": 1}, "bodies": {}}'
BODY = HEAD + "bodies:\n  gear:\n    "


def faults(text: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        parsed(read_document(text.encode(), "s.yaml"))
    return [str(fault).removeprefix("s.yaml:") for fault in caught.value.faults]


def accepted(text: str) -> SceneFile:
    return parsed(read_document(text.encode(), "s.yaml"))


def test_the_address_of_a_schema_is_accepted_and_never_suggested() -> None:
    assert accepted('{"$schema": "../closecall.schema.json", "closecall": 1, ' + JSON_REST).bodies == {}
    (line,) = faults(HEAD + "bodies: {}\nschema: a.json\n")
    assert line.startswith("5:1: scene: unknown key 'schema', expected closecall, units, time, settings, meshes")


def test_a_least_scene_is_accepted() -> None:
    scene = accepted(HEAD + "bodies: {}\n")
    assert (scene.time.start, scene.time.end) == (0.0, 1.0)
    assert type(scene.time.end) is float


@pytest.mark.parametrize(
    ("text", "begin", "phrase"),
    [
        ("[]", "1:1: scene: ", "expected a mapping, got a list"),
        ("scene", "1:1: scene: ", "expected a mapping, got 'scene'"),
        (HEAD, "1:1: scene: ", "missing key 'bodies'"),
        (HEAD + "bodis: {}\n", "4:1: scene: ", "unknown key 'bodis' (did you mean 'bodies'?)"),
        (HEAD + "bodies: []\n", "4:9: bodies: ", "expected a mapping, got a list"),
        (HEAD + "bodies: {a: 5}\n", "4:13: bodies.a: ", "expected a mapping, got 5"),
        (HEAD.replace("m,", "km,") + "bodies: {}", "2:17: units.length: ", "expected m, cm, mm, in or ft, got 'km'"),
        (HEAD.replace("deg", "grad") + "bodies: {}", "2:27: units.angle: ", "expected deg or rad, got 'grad'"),
        (HEAD.replace(", angle: deg", "") + "bodies: {}", "2:1: units: ", "missing key 'angle'"),
        (HEAD.replace("end: 1", "end: soon") + "bodies: {}", "3:23: time.end: ", "expected a number, got 'soon'"),
        (HEAD.replace("end: 1", "end: true") + "bodies: {}", "3:23: time.end: ", "expected a number, got true"),
        (HEAD.replace("end: 1", "end: '1'") + "bodies: {}", "3:23: time.end: ", "expected a number, got '1'"),
        (HEAD.replace("end: 1", "end: 1e16") + "bodies: {}", "3:23: time.end: ", "at most 1e+15, got 1e+16"),
        (
            HEAD + "settings: {time_resolution: 0}\nbodies: {}",
            "4:29: settings.time_resolution: ",
            "greater than 0, got 0",
        ),
        (
            HEAD + "settings: {contact_tolerance: -1}\nbodies: {}",
            "4:31: settings.contact_tolerance: ",
            "greater than 0, got -1",
        ),
        (HEAD + "settings: {margin: -1}\nbodies: {}", "4:20: settings.margin: ", "of at least 0, got -1"),
        (
            HEAD + "settings: {margins: 1}\nbodies: {}",
            "4:12: settings: ",
            "unknown key 'margins' (did you mean 'margin'?), expected time_resolution, contact_tolerance, margin or",
        ),
        (
            HEAD + "settings: {distance_tolerance: wide}\nbodies: {}",
            "4:32: settings.distance_tolerance: ",
            "expected a number or none, got 'wide'",
        ),
        (HEAD + "settings: {distance_tolerance: 1}\nbodies: {}", "4:32: settings.", "a number less than 1, got 1"),
        (HEAD + "settings: {distance_tolerance: 0}\nbodies: {}", "4:32: settings.", "greater than 0, got 0"),
        (
            HEAD + "settings: {margin: 5 mm}\nbodies: {}",
            "4:20: settings.margin: ",
            "got '5 mm': write the number alone, 'units' says its unit",
        ),
        (
            HEAD.replace("end: 1", "end: 90deg") + "bodies: {}",
            "3:23: time.end: ",
            "got '90deg': write the number alone, 'units' says its unit",
        ),
        (HEAD.replace("closecall: 1\n", "") + "bodies: {}", "1:1: scene: ", "missing key 'closecall', expected 1"),
        (HEAD + "meshes: {a: {file: x.obj}}\nbodies: {}", "4:10: meshes.a: ", "key 'units', expected m, cm, mm"),
        (HEAD + "meshes: {a: {file: x.obj, units: mm, up: x}}\nbodies: {}", "4:42: meshes.a.up: ", "expected z or y"),
        (
            HEAD + "meshes: {a: {file: '', units: mm}}\nbodies: {}",
            "4:20: meshes.a.file: ",
            "expected text, got an empty one",
        ),
        (HEAD + "meshes: {a: {file: 5, units: mm}}\nbodies: {}", "4:20: meshes.a.file: ", "expected text, got 5"),
        (BODY + "exists: 1", "6:13: bodies.gear.exists: ", "expected a list, got 1"),
        (BODY + "exists: [1]", "6:13: bodies.gear.exists: ", "expected 2 numbers, got 1"),
        (BODY + "exists: [1, 2, 3]", "6:13: bodies.gear.exists: ", "expected 2 numbers, got 3"),
        (BODY + "exists: [0, forever]", "6:17: bodies.gear.exists[1]: ", "expected a number, got 'forever'"),
        (
            BODY + "exist: [0, 1]",
            "6:5: bodies.gear: ",
            "unknown key 'exist' (did you mean 'exists'?), expected parent, pose, shapes, motion, groups or exists",
        ),
        (BODY + "groups: drive", "6:13: bodies.gear.groups: ", "expected a list, got 'drive'"),
        (BODY + "groups: [1]", "6:14: bodies.gear.groups[0]: ", "expected text, got 1"),
        (BODY + "parent: [a]", "6:13: bodies.gear.parent: ", "expected text, got a list"),
        (BODY + "pose: {quat: [1, 0, 0, 0]}", "6:12: bodies.gear.pose: ", "unknown key 'quat' (did you mean"),
        (BODY + "pose: {xyz: [1, 2]}", "6:17: bodies.gear.pose.xyz: ", "expected 3 numbers, got 2"),
        (BODY + "pose: {xyz: []}", "6:17: bodies.gear.pose.xyz: ", "expected 3 numbers, got 0"),
        (BODY + "pose: {xyz: [1, 2, 3, 4]}", "6:17: bodies.gear.pose.xyz: ", "expected 3 numbers, got 4"),
        (BODY + "pose: {xyz: 1}", "6:17: bodies.gear.pose.xyz: ", "expected a list, got 1"),
        (BODY + "pose: {xyz: {x: 1}}", "6:17: bodies.gear.pose.xyz: ", "expected a list, got a mapping"),
        (BODY + "pose: {quat_wxyz: [1, 0, 0]}", "6:23: bodies.gear.pose.quat_wxyz: ", "expected 4 numbers, got 3"),
        (BODY + "pose: {matrix: [[1, 0, 0, 0]]}", "6:20: bodies.gear.pose.matrix: ", "expected 4 lists, got 1"),
        (BODY + "pose: {axis_angle: {axis: [0, 0, 1]}}", "6:12: bodies.gear.pose.axis_angle: ", "missing key 'angle'"),
        (BODY + "pose: {rpy: [0, 0, 0], quat_xyzw: [0, 0, 0, 1]}", "6:11: bodies.gear.pose: ", "got quat_xyzw and rpy"),
        (
            BODY + "pose: {xyz: [0, 0, 0], matrix: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}",
            "6:11: bodies.gear.pose: ",
            "expected matrix alone",
        ),
        (BODY + "shapes: [5]", "6:14: bodies.gear.shapes[0]: ", "expected a mapping with the key mesh, box"),
        (
            BODY + "shapes: [{}]",
            "6:14: bodies.gear.shapes[0]: ",
            "missing key, expected mesh, box, sphere, capsule, cylinder, cone or ellipsoid",
        ),
        (BODY + "shapes: [{pose: {}}]", "6:14: bodies.gear.shapes[0]: ", "missing key, expected mesh, box"),
        (
            BODY + "shapes: [{sphre: 1}]",
            "6:15: bodies.gear.shapes[0]: ",
            "unknown shape 'sphre' (did you mean 'sphere'?)",
        ),
        (BODY + "shapes: [{sphere: 1, box: [1, 1, 1]}]", "6:14: bodies.gear.shapes[0]: ", "got box and sphere"),
        (
            BODY + "shapes: [{mesh: a, pos: {}}]",
            "6:24: bodies.gear.shapes[0]: ",
            "unknown key 'pos' (did you mean 'pose'?)",
        ),
        (BODY + "shapes: [{sphere: 0}]", "6:23: bodies.gear.shapes[0].sphere: ", "greater than 0, got 0"),
        (BODY + "shapes: [{sphere: 1e-300}]", "6:23: bodies.gear.shapes[0].sphere: ", "at least 1e-15"),
        (BODY + "shapes: [{box: [1, -1, 1]}]", "6:24: bodies.gear.shapes[0].box[1]: ", "greater than 0, got -1"),
        (
            BODY + "shapes: [{capsule: {radius: 1, length: 0}}]",
            "6:44: bodies.gear.shapes[0].capsule.length: ",
            "greater than 0",
        ),
        (BODY + "shapes: [{capsule: 1}]", "6:24: bodies.gear.shapes[0].capsule: ", "expected a mapping, got 1"),
        (HEAD + "bodies: {}\npairs: {default: no}", "5:18: pairs.default: ", "expected check or ignore, got 'no'"),
        (HEAD + "bodies: {}\npairs: {default: ignored}", "5:18: pairs.default: ", "(did you mean 'ignore'?)"),
        (HEAD + "bodies: {}\npairs: {margins: 1}", "5:18: pairs.margins: ", "expected a list, got 1"),
        (
            HEAD + "bodies: {}\npairs: {margins: [{between: [a, b]}]}",
            "5:19: pairs.margins[0]: ",
            "missing key 'margin'",
        ),
        (
            HEAD + "bodies: {}\npairs: {margins: [{between: [a, b], margin: -1}]}",
            "5:45: pairs.margins[0].margin: ",
            "expected a number of at least 0, got -1",
        ),
        (
            HEAD + "bodies: {}\npairs: {margins: [{between: [a, b], margin: wide}]}",
            "5:45: pairs.margins[0].margin: ",
            "expected a number, got 'wide'",
        ),
        (
            HEAD + "bodies: {}\npairs: {ignore: [{between: [a, b], margin: 1}]}",
            "5:36: pairs.ignore[0]: ",
            "unknown key 'margin', expected between or reason",
        ),
        (
            HEAD + "bodies: {}\npairs: {ignores: []}",
            "5:9: pairs: ",
            "unknown key 'ignores' (did you mean 'ignore'?), expected default, ignore, check or margins",
        ),
        ("$schema: 5\n" + HEAD + "bodies: {}", "1:10: ['$schema']: ", "expected text, got 5"),
        (
            HEAD + "bodies: {}\npairs: {ignore: [{between: [a]}]}",
            "5:28: pairs.ignore[0].between: ",
            "expected 2 names, got 1",
        ),
        (
            HEAD + "bodies: {}\npairs: {ignore: [{between: [a, b, c]}]}",
            "5:28: pairs.ignore[0].between: ",
            "expected 2 names, got 3",
        ),
        (
            HEAD + "bodies: {}\npairs: {check: [{between: [a, 1]}]}",
            "5:31: pairs.check[0].between[1]: ",
            "expected text, got 1",
        ),
        (
            HEAD + "bodies: {}\npairs: {check: [{betwen: [a, b], between: [a, b]}]}",
            "5:18: pairs.check[0]: ",
            "did you mean 'between'?",
        ),
    ],
)
def test_bad_grammar_is_refused_in_one_line_at_its_place(text: str, begin: str, phrase: str) -> None:
    told = faults(text)
    matching = [line for line in told if line.startswith(begin)]
    assert len(matching) == 1, told
    assert phrase in matching[0]
    assert all("\n" not in line for line in told)


@pytest.mark.parametrize("version", ["2", "true", "'1'", "[1]", "1.5"])
def test_another_format_version_is_the_only_fault_told(version: str) -> None:
    (line,) = faults(f"closecall: {version}\nnews: 5\n")
    assert line.startswith("1:12: closecall: expected format version 1, got ")


def test_a_whole_number_written_as_a_float_is_a_version() -> None:
    assert accepted(HEAD.replace("closecall: 1", "closecall: 1.0") + "bodies: {}").closecall == 1


def test_all_faults_are_told_in_the_order_of_the_file() -> None:
    told = faults(
        "closecall: 1\n"
        "units: {length: m}\n"
        "time: {start: a, end: b}\n"
        "bodies:\n"
        "  a: {motion: {type: keyframes, keys: [{t: x}, {t: y}]}}\n"
        "  b: {shapes: [{sphere: no}, {box: [1, 2]}]}\n"
    )
    assert [line.split(": ")[0] for line in told] == ["2:1", "3:15", "3:23", "5:44", "5:52", "6:25", "6:36"]


def test_names_with_dots_or_brackets_cannot_be_mistaken_for_paths() -> None:
    (line,) = faults(HEAD + "bodies: {'a.b[0]': {pos: {}}}")
    assert line.startswith("4:21: bodies['a.b[0]']: unknown key 'pos'")


def test_hostile_text_stays_within_its_line() -> None:
    (line,) = faults(HEAD + 'bodies: {"a\\n\\u202eb": {"p\\nq": {}}}')
    assert line.isprintable()
    (line,) = faults(HEAD + f"bodies: {{a: {'x' * 10_000}}}")
    assert len(line) < 200


def test_every_field_says_what_it_is_for_and_numbers_their_unit() -> None:
    schema = SceneFile.model_json_schema()
    for definition in (schema, *schema["$defs"].values()):
        for name, field in definition.get("properties", {}).items():
            assert name == "type" or field.get("description"), (definition["title"], name)
