"""What the grammar cannot see: names, references, times and files that do not fit, each told at its place."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import pytest
from scene_files import HEAD, faults

from closecall.formats.scene.build.existence import needed_times
from closecall.formats.scene.grammar.scene import TimeRange
from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.text.errors import SceneError

BODIES = f"{HEAD}bodies:\n  a: {{groups: [g]}}\n  b: {{groups: [g]}}\n  c: {{groups: [h]}}\n"


@pytest.mark.parametrize(
    ("text", "begin", "phrase"),
    [
        (
            HEAD.replace("end: 1", "end: 0") + "bodies: {}",
            "3:23: time.end: ",
            "expected an end after the start (0 s), got 0 s",
        ),
        (HEAD.replace("end: 1", "end: -1") + "bodies: {}", "3:23: time.end: ", "got -1 s"),
        (
            HEAD.replace("end: 1", "end: 1e15") + "bodies: {}",
            "3:23: time.end: ",
            "time_resolution 0.001 s is too short for times near",
        ),
        (
            HEAD.replace("end: 1", "end: 1e5") + "settings:\n  time_resolution: 1e-12\nbodies: {}",
            "5:20: settings.time_resolution: ",
            "time_resolution 1e-12 s is too short for times near 100000 s, expected at least",
        ),
        (
            HEAD + "settings: {contact_tolerance: 1e-15}\nbodies: {b: {}}",
            "4:31: settings.contact_tolerance: ",
            "is too short",
        ),
        (HEAD + "bodies: {world: {}}", "4:10: bodies.world: ", "reserved"),
        (HEAD + "bodies: {a/b: {}}", "4:10: bodies['a/b']: ", "the character / is not allowed"),
        (HEAD + "bodies: {'a|b': {}}", "4:10: bodies['a|b']: ", "the character | is not allowed"),
        (HEAD + "bodies: {'': {}}", "4:10: bodies['']: ", "blank"),
        (HEAD + 'bodies: {"a\\u202e": {}}', "4:10: bodies['a\\u202e']: ", "U+202E"),
        (HEAD + 'bodies: {"a\\t": {}}', "4:10: bodies['a\\t']: ", "U+0009"),
        (HEAD + 'bodies: {"\\u00e9": {}, "e\\u0301": {}}', "4:24: bodies[", "appears twice"),
        (
            HEAD + "meshes: {a*: {file: crank.obj, units: m}}\nbodies: {}",
            "4:10: meshes['a*']: ",
            "the character * is not allowed",
        ),
        (HEAD + "bodies: {a: {parent: b}}", "4:22: bodies.a.parent: ", "unknown body 'b'"),
        (HEAD + "bodies: {gear: {}, a: {parent: geer}}", "4:32: bodies.a.parent: ", "(did you mean 'gear'?)"),
        (HEAD + "bodies: {a: {parent: world}}", "4:22: bodies.a.parent: ", "leave the key out"),
        (HEAD + "bodies: {a: {parent: a}}", "4:22: bodies.a.parent: ", "its own parent"),
        (
            HEAD + "bodies: {x: {parent: c}, b: {parent: c}, c: {parent: b}}",
            "4:38: bodies.b.parent: ",
            "('b' -> 'c' -> 'b')",
        ),
        (HEAD + "bodies: {a: {shapes: [{mesh: crank}]}}", "4:30: bodies.a.shapes[0].mesh: ", "unknown mesh 'crank'"),
        (
            HEAD + "meshes: {m: {file: none.obj, units: m}}\nbodies: {}",
            "4:20: meshes.m.file: ",
            "none.obj: the file cannot be read",
        ),
        (HEAD + "meshes: {m: {file: ../crank.obj, units: m}}\nbodies: {}", "4:20: meshes.m.file: ", "lies outside"),
        (
            HEAD + "meshes: {m: {file: bad.obj, units: m}}\nbodies: {}",
            "4:20: meshes.m.file: ",
            "bad.obj:2: expected a finite coordinate",
        ),
        (BODIES + "  d: {groups: [a]}", "8:16: bodies.d.groups[0]: ", "has the name of a body"),
        (BODIES + "  d: {groups: ['a?']}", "8:16: bodies.d.groups[0]: ", "the character ? is not allowed"),
        (
            BODIES + "pairs: {ignore: [{between: [a, x]}]}",
            "8:32: pairs.ignore[0].between[1]: ",
            "unknown body or group 'x'",
        ),
        (
            BODIES + "pairs: {check: [{between: ['z*', a]}]}",
            "8:28: pairs.check[0].between[0]: ",
            "'z*' matches no body",
        ),
        (
            BODIES + "pairs: {ignore: [{between: [a, a]}]}",
            "8:32: pairs.ignore[0].between[1]: ",
            "both sides are the body 'a'",
        ),
        (
            BODIES + "pairs: {ignore: [{between: [h, 'c*']}]}",
            "8:32: pairs.ignore[0].between[1]: ",
            "both sides are the body 'c'",
        ),
    ],
)
def test_what_the_grammar_cannot_see_is_refused_at_its_place(
    tmp_path: Path, text: str, begin: str, phrase: str
) -> None:
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 0 nan 0\n")
    told = [line for line in faults(tmp_path, text) if line.startswith(begin)]
    assert told
    assert phrase in told[0]


def test_independent_faults_are_told_together_in_order(tmp_path: Path) -> None:
    told = faults(
        tmp_path,
        f"{HEAD}meshes: {{m: {{file: none.obj, units: m}}}}\n"
        "bodies:\n"
        "  a: {parent: q, pose: {quat_wxyz: [0, 0, 0, 0]}, shapes: [{mesh: m}, {mesh: n}]}\n"
        "pairs: {ignore: [{between: [a, r]}, {between: [s, a]}]}\n",
    )
    assert [line.split(": ")[1] for line in told] == [
        "meshes.m.file",
        "bodies.a.parent",
        "bodies.a.pose.quat_wxyz",
        "bodies.a.shapes[1].mesh",
        "pairs.ignore[0].between[1]",
        "pairs.ignore[1].between[0]",
    ]


def test_faults_of_every_section_are_told_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    told = faults(
        tmp_path,
        HEAD.replace("end: 1", "end: 0") + "bodies:\n"
        "  a: {exists: [1, 1], motion: {type: orbit, axis: [0, 0, 1], start: [0, 0, 1], radius: 1, rate: 1}}\n"
        "  b:\n"
        "    motion: {type: keyframes, after: loop, keys: [{t: 3, name: '*', velocity: [0, 0, 0]}]}\n"
        "    shapes: [{mesh: m}]\n"
        "  c: {motion: {type: file, file: none.csv, layout: csv}}\n"
        "  d: {motion: {type: profile, kind: slide, axis: [0, 0, 0], point: [0, 0, 0], "
        "from: 0, to: 1, max_velocity: 1, max_acceleration: 1}}\n"
        "pairs: {margins: [{between: [a, x], margin: 1}], check: [{between: ['y*', a]}]}\n",
    )
    assert [line.split(": ")[1] for line in told] == [
        "time.end",
        "bodies.a.exists[1]",
        "bodies.a.motion.start",
        "bodies.b.motion.after",
        "bodies.b.motion.keys[0].t",
        "bodies.b.motion.keys[0].name",
        "bodies.b.motion.keys[0].velocity",
        "bodies.b.shapes[0].mesh",
        "bodies.c.motion.file",
        "bodies.d.motion.axis",
        "bodies.d.motion.point",
        "pairs.margins[0].between[1]",
        "pairs.check[0].between[0]",
    ]


def test_thousands_of_misspelt_names_are_told_without_comparing_all_of_them(tmp_path: Path) -> None:
    bodies = "".join(f"  body_{i}: {{parent: bodi_{i}}}\n" for i in range(1000))
    began = perf_counter()
    told = faults(tmp_path, f"{HEAD}bodies:\n{bodies}")
    assert perf_counter() - began < 20.0  # all 1,000,000 comparisons take over a minute
    assert len(told) == 1000
    assert told[0].endswith("(did you mean 'body_0'?)")
    assert told[-1].endswith("unknown body 'bodi_999'")


def test_times_needed_along_a_long_chain_are_found_in_one_pass() -> None:
    count = 20_000
    parents = [None, *range(count - 1)]
    exists = [(float(count - i), float(count + i + 1)) for i in range(count)]
    needed = needed_times(parents, exists, TimeRange(start=10.0, end=1e9))
    assert needed[0] == (10.0, 2.0 * count)
    assert needed[-2:] == [(10.0, 2.0 * count), (10.0, 2.0 * count)]


def test_times_needed_in_a_circle_of_parents_are_found_without_end() -> None:
    assert len(needed_times([1, 0, 0], [(0.0, 1.0)] * 3, TimeRange(start=0.0, end=9.0))) == 3


def test_a_long_circle_of_parents_is_found_without_recursion(tmp_path: Path) -> None:
    lines = "".join(f"  b{i}: {{parent: b{i - 1}}}\n" for i in range(1, 5000))
    (line,) = faults(tmp_path, f"{HEAD}bodies:\n  b0: {{parent: b4999}}\n{lines}")
    assert line.startswith("5:16: bodies.b0.parent: the parents go in a circle")


def test_a_scene_that_is_not_there_is_a_fault(tmp_path: Path) -> None:
    for path in (tmp_path / "none.yaml", tmp_path, tmp_path / "a.yaml" / "b", Path("\0")):
        with pytest.raises(SceneError, match=":1:1: scene: the file cannot be read"):
            read_scene(path)
