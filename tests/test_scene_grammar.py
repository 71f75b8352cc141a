"""What the grammar refuses, and in which words: one line a fault, at its key or value."""

from __future__ import annotations

import pytest

from closecall.formats.scene.errors import SceneError
from closecall.formats.scene.grammar import SceneFile
from closecall.formats.scene.source import read_document
from closecall.formats.scene.wording import parsed

HEAD = "closecall: 1\nunits: {length: m, angle: deg}\ntime: {start: 0, end: 1}\n"
BODY = HEAD + "bodies:\n  gear:\n    "
MOTION = BODY + "motion: "


def faults(text: str) -> list[str]:
    with pytest.raises(SceneError) as caught:
        parsed(read_document(text.encode(), "s.yaml"))
    return [str(fault).removeprefix("s.yaml:") for fault in caught.value.faults]


def accepted(text: str) -> SceneFile:
    return parsed(read_document(text.encode(), "s.yaml"))


def test_a_least_scene_is_accepted() -> None:
    scene = accepted(HEAD + "bodies: {}\n")
    assert (scene.time.start, scene.time.end) == (0.0, 1.0)
    assert type(scene.time.end) is float


@pytest.mark.parametrize(
    "motion",
    [
        "{type: constant}",
        "{type: constant, velocity: [1, 2, 3], angular_velocity: [0, 0, 1e-3]}",
        "{type: ballistic, velocity: [1, 2, 3], acceleration: [0, 0, -9.81], angular_velocity: [0, 0, 1]}",
        "{type: screw, axis: [0, 0, 1], point: [1, 0, 0], rate: 90, pitch: 0.01}",
        "{type: screw, axis: [0, 0, 1], rate: 90}",
        "{type: harmonic, direction: [1, 0, 0], amplitude: 0.4, period: 2, phase: 90}",
        "{type: harmonic, direction: [1, 0, 0], amplitude: 0.4, period: 2}",
        "{type: swing, axis: [0, 1, 0], point: [0, 0, 1], amplitude: 60, period: 0.7, phase: 1}",
        "{type: keyframes, keys: [{t: 0}, {t: 1, xyz: [1, 2, 3], quat_wxyz: [1, 0, 0, 0]}]}",
        "{type: keyframes, keys: [{t: 0}], interpolation: {translation: step, rotation: step}}",
    ],
)
def test_every_motion_of_this_version_is_accepted(motion: str) -> None:
    assert accepted(MOTION + motion).bodies["gear"].motion is not None


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
        (HEAD + "settings: {margin: 1}\nbodies: {}", "4:12: settings: ", "'margin' is not supported by this version"),
        (HEAD + "meshes: {a: {file: x.obj}}\nbodies: {}", "4:10: meshes.a: ", "missing key 'units'"),
        (HEAD + "meshes: {a: {file: x.obj, units: mm, up: x}}\nbodies: {}", "4:42: meshes.a.up: ", "expected z or y"),
        (
            HEAD + "meshes: {a: {file: '', units: mm}}\nbodies: {}",
            "4:20: meshes.a.file: ",
            "expected text, got an empty one",
        ),
        (HEAD + "meshes: {a: {file: 5, units: mm}}\nbodies: {}", "4:20: meshes.a.file: ", "expected text, got 5"),
        (BODY + "exists: [0, 1]", "6:5: bodies.gear: ", "'exists' is not supported by this version"),
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
        (BODY + "shapes: [{}]", "6:14: bodies.gear.shapes[0]: ", "missing key, expected mesh, box, sphere or capsule"),
        (BODY + "shapes: [{pose: {}}]", "6:14: bodies.gear.shapes[0]: ", "missing key, expected mesh, box"),
        (
            BODY + "shapes: [{sphre: 1}]",
            "6:15: bodies.gear.shapes[0]: ",
            "unknown shape 'sphre' (did you mean 'sphere'?)",
        ),
        (BODY + "shapes: [{sphere: 1, box: [1, 1, 1]}]", "6:14: bodies.gear.shapes[0]: ", "got box and sphere"),
        (
            BODY + "shapes: [{cylinder: {radius: 1, length: 1}}]",
            "6:15: bodies.gear.shapes[0]: ",
            "'cylinder' shapes are not supported by this version",
        ),
        (BODY + "shapes: [{cone: {}}]", "6:15: bodies.gear.shapes[0]: ", "'cone' shapes are not"),
        (BODY + "shapes: [{ellipsoid: []}]", "6:15: bodies.gear.shapes[0]: ", "'ellipsoid' shapes are not"),
        (
            BODY + "shapes: [{mesh: a, scale: 2}]",
            "6:24: bodies.gear.shapes[0]: ",
            "'scale' is not supported by this version",
        ),
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
        (MOTION + "fast", "6:13: bodies.gear.motion: ", "expected a mapping with the key 'type', got 'fast'"),
        (MOTION + "{}", "6:5: bodies.gear.motion: ", "missing key 'type'"),
        (MOTION + "{type: 5}", "6:20: bodies.gear.motion.type: ", "unknown motion 5"),
        (MOTION + "{type: [a]}", "6:20: bodies.gear.motion.type: ", "unknown motion a list"),
        (MOTION + "{type: balistic}", "6:20: bodies.gear.motion.type: ", "(did you mean 'ballistic'?)"),
        *(
            (
                MOTION + f"{{type: {name}}}",
                "6:20: bodies.gear.motion.type: ",
                f"'{name}' motions are not supported by this version",
            )
            for name in ("orbit", "polynomial", "profile", "file", "limits")
        ),
        (
            MOTION + "{type: constant, veloctiy: [0, 0, 0]}",
            "6:30: bodies.gear.motion: ",
            "unknown key 'veloctiy' (did you mean 'velocity'?)",
        ),
        (MOTION + "{type: constant, constant: 1}", "6:30: bodies.gear.motion: ", "unknown key 'constant'"),
        (MOTION + "{type: constant, t0: 1}", "6:30: bodies.gear.motion: ", "'t0' is not supported by this version"),
        (MOTION + "{type: screw, rate: 1}", "6:5: bodies.gear.motion: ", "missing key 'axis'"),
        (
            MOTION + "{type: swing, axis: [0, 0, 1], amplitude: 1, period: 0}",
            "6:66: bodies.gear.motion.period: ",
            "greater than 0, got 0",
        ),
        (
            MOTION + "{type: harmonic, direction: [0, 0, 1], amplitude: 1, period: -2}",
            "6:74: bodies.gear.motion.period: ",
            "got -2",
        ),
        (MOTION + "{type: keyframes, keys: []}", "6:37: bodies.gear.motion.keys: ", "expected at least one entry"),
        (
            MOTION + "{type: keyframes, keys: [{xyz: [0, 0, 0]}]}",
            "6:38: bodies.gear.motion.keys[0]: ",
            "missing key 't'",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: abc}]}",
            "6:42: bodies.gear.motion.keys[0].t: ",
            "expected a number, got 'abc'",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: 0, name: a}]}",
            "6:45: bodies.gear.motion.keys[0]: ",
            "'name' is not supported",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: 0, velocity: a}]}",
            "6:45: bodies.gear.motion.keys[0]: ",
            "'velocity' is not supported",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: 0}], before: hold}",
            "6:47: bodies.gear.motion: ",
            "'before' is not supported",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: 0}], interpolation: {translation: cubic}}",
            "6:76: bodies.gear.motion.interpolation.translation: ",
            "'cubic' is not supported by this version",
        ),
        (
            MOTION + "{type: keyframes, keys: [{t: 0}], interpolation: {rotation: lerp}}",
            "6:73: bodies.gear.motion.interpolation.rotation: ",
            "expected slerp or step, got 'lerp' (did you mean 'slerp'?)",
        ),
        (HEAD + "bodies: {}\npairs: {default: check}", "5:9: pairs: ", "'default' is not supported by this version"),
        (HEAD + "bodies: {}\npairs: {margins: []}", "5:9: pairs: ", "'margins' is not supported by this version"),
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
