"""Every named item of bad input, from the command line on: exit 2, one located line a fault, nothing written."""

from __future__ import annotations

import re
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from scene_files import HEAD, TETRAHEDRON

from closecall.cli.main import main

LINE = re.compile(r"s\.yaml:[0-9]+:[0-9]+: [^ ].*: .+")
FILES = {
    "m.obj": TETRAHEDRON,
    "empty.stl": "",
    "cut.obj": TETRAHEDRON[:-5],
    "cut.stl": "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
    "points.obj": "v 0 0 0\nv 1 0 0\n",
    "range.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
    "nan.obj": "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n",
    "short.tum": "0 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n",
    "back.tum": "0 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n",
}


def body(text: str) -> str:
    return f"{HEAD}bodies:\n  gear: {{{text}}}\n  bench: {{groups: [static]}}\n"


def mesh(file: str) -> str:
    return f"{HEAD}meshes: {{plate: {{file: {file}, units: mm}}}}\nbodies: {{a: {{shapes: [{{mesh: plate}}]}}}}\n"


def keys(text: str) -> str:
    return body(f"motion: {{type: keyframes, keys: [{text}]}}")


def pairs(one: str, other: str) -> str:
    return body("") + f"pairs: {{ignore: [{{between: ['{one}', '{other}']}}]}}\n"


ITEMS = {
    "nan": (body("pose: {xyz: [.nan, 0, 0]}"), "5:23: bodies.gear.pose.xyz[0]: expected a finite number"),
    "inf": (body("pose: {xyz: [0, -.inf, 0]}"), "5:26: bodies.gear.pose.xyz[1]: expected a finite number"),
    "1e400": (body("pose: {xyz: [0, 0, 1e400]}"), "5:29: bodies.gear.pose.xyz[2]: expected a finite number"),
    "zero quaternion": (body("pose: {quat_wxyz: [0, 0, 0, 0]}"), "5:28: bodies.gear.pose.quat_wxyz: "),
    "non-unit quaternion": (body("pose: {quat_xyzw: [0, 0, 0, 1.01]}"), "5:28: bodies.gear.pose.quat_xyzw: "),
    "bare quat": (body("pose: {quat: [1, 0, 0, 0]}"), "5:17: bodies.gear.pose: unknown key 'quat'"),
    "mirrored": (
        body("pose: {matrix: [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}"),
        "5:25: bodies.gear.pose.matrix: ",
    ),
    "scaled": (
        body("pose: {matrix: [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]}"),
        "5:25: bodies.gear.pose.matrix: ",
    ),
    "keys not increasing": (keys("{t: 0}, {t: 1}, {t: 0.5}"), "5:63: bodies.gear.motion.keys[2].t: expected a time"),
    "two poses at one time": (keys("{t: 0}, {t: 0}, {t: 1}"), "5:55: bodies.gear.motion.keys[1].t: two keys at 0 s"),
    "keys too short": (keys("{t: 0}, {t: 0.5}"), "5:55: bodies.gear.motion.keys[1].t: expected the last pose at 1 s"),
    "end before start": (HEAD.replace("end: 1", "end: -1") + "bodies: {}\n", "3:23: time.end: expected an end after"),
    "resolution 0": (
        body("") + "settings: {time_resolution: 0}\n",
        "7:29: settings.time_resolution: expected a",
    ),
    "resolution below spacing": (
        HEAD.replace("end: 1", "end: 1e15") + "settings: {contact_tolerance: 100}\nbodies: {}\n",
        "3:23: time.end: time_resolution 0.001 s is too short for times near 1000000000000000 s",
    ),
    "zero size": (
        body("shapes: [{sphere: 0}]"),
        "5:28: bodies.gear.shapes[0].sphere: expected a number greater than 0",
    ),
    "negative size": (body("shapes: [{box: [1, -1, 1]}]"), "5:29: bodies.gear.shapes[0].box[1]: expected a number"),
    "zero scale": (
        mesh("m.obj").replace("mesh: plate", "mesh: plate, scale: 0"),
        "5:44: bodies.a.shapes[0].scale: expected a number greater than 0",
    ),
    "missing mesh": (mesh("none.obj"), "4:24: meshes.plate.file: none.obj: the file cannot be read: No such file"),
    "unreadable mesh": (mesh("folder.obj"), "4:24: meshes.plate.file: folder.obj: expected a file"),
    "empty mesh": (mesh("empty.stl"), "4:24: meshes.plate.file: empty.stl: "),
    "truncated OBJ": (mesh("cut.obj"), "4:24: meshes.plate.file: cut.obj:8: expected a face with at least 3 corners"),
    "truncated STL": (mesh("cut.stl"), "4:24: meshes.plate.file: cut.stl:4: the file is cut short"),
    "point-only mesh": (mesh("points.obj"), "4:24: meshes.plate.file: points.obj: the file has no faces"),
    "index out of range": (mesh("range.obj"), "4:24: meshes.plate.file: range.obj:4: "),
    "NaN vertex": (mesh("nan.obj"), "4:24: meshes.plate.file: nan.obj:2: expected a finite coordinate, got 'nan'"),
    "absolute mesh": (mesh("/etc/m.obj"), "4:24: meshes.plate.file: /etc/m.obj is absolute"),
    "mesh outside": (mesh("../m.obj"), "4:24: meshes.plate.file: ../m.obj lies outside the scene's folder"),
    "mesh at a URL": (mesh("'http://a.b/m.obj'"), "4:24: meshes.plate.file: http://a.b/m.obj is a URL"),
    "short trajectory": (
        body("motion: {type: file, layout: tum, file: short.tum}"),
        "5:50: bodies.gear.motion.file: short.tum:2: expected the last pose at 1 s",
    ),
    "trajectory back in time": (
        body("motion: {type: file, layout: tum, file: back.tum}"),
        "5:50: bodies.gear.motion.file: back.tum:3: expected a time after that of line 2 (2 s), got 1 s",
    ),
    "unknown body": (pairs("geer", "bench"), "7:29: pairs.ignore[0].between[0]: unknown body or group 'geer' (did you"),
    "unknown group": (pairs("gear", "statik"), "(did you mean 'static'?)"),
    "unknown parent": (body("parent: bensh"), "5:18: bodies.gear.parent: unknown body 'bensh' (did you mean 'bench'?)"),
    "unknown mesh": (
        mesh("m.obj").replace("mesh: plate", "mesh: plaet"),
        "5:30: bodies.a.shapes[0].mesh: unknown mesh 'plaet' (did you mean 'plate'?)",
    ),
    "unknown key": (body("pos: {}"), "5:10: bodies.gear: unknown key 'pos' (did you mean 'pose'?)"),
    "duplicate name": (HEAD + "bodies:\n  a: {}\n  a: {}\n", "6:3: bodies.a: the key 'a' appears twice"),
    "duplicate key": (HEAD + "time: {start: 0, end: 2}\nbodies: {}\n", "4:1: time: the key 'time' appears twice"),
    "NFC-equal names": (HEAD + 'bodies: {"\\u00e9": {}, "e\\u0301": {}}\n', "the name appears twice"),
    "bidirectional name": (
        HEAD + 'bodies: {"a\\u202e": {}}\n',
        "4:10: bodies['a\\u202e']: the character U+202E is",
    ),
    "control character": (HEAD + 'bodies: {"a\\u0007": {}}\n', "4:10: bodies['a\\x07']: the character U+0007 is not"),
    "forbidden character": (HEAD + "bodies: {'a|b': {}}\n", "4:10: bodies['a|b']: the character | is not allowed"),
    "the name world": (HEAD + "bodies: {world: {}}\n", "4:10: bodies.world: the name 'world' is reserved"),
    "self parent": (body("parent: gear"), "5:18: bodies.gear.parent: "),
    "cyclic parents": (
        HEAD + "bodies: {a: {parent: b}, b: {parent: a}}\n",
        "4:22: bodies.a.parent: the parents go",
    ),
    "a pair of a body with itself": (pairs("gear", "g*"), "7:37: pairs.ignore[0].between[1]: expected two bodies"),
    "a glob without match": (pairs("z*", "gear"), "7:29: pairs.ignore[0].between[0]: the pattern 'z*' matches no body"),
    "alias": (HEAD + "bodies: {a: &x {}, b: *x}\n", "4:13: bodies.a: the anchor '&x' is not allowed"),
    "tag": (HEAD + "bodies: {a: !!map {}}\n", "4:13: bodies.a: the tag 'tag:yaml.org,2002:map' is not"),
    "nesting": (HEAD + f"bodies: {'[' * 64}{']' * 64}\n", "nested more than 64 deep"),
    "unknown unit": (
        HEAD.replace("mm", "mn") + "bodies: {}\n",
        "2:17: units.length: expected m, cm, mm, in or ft",
    ),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "folder.obj").mkdir()
    monkeypatch.chdir(tmp_path)
    handler = signal.getsignal(signal.SIGTERM)
    yield tmp_path
    signal.signal(signal.SIGTERM, handler)


def refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must exit with 2 and print nothing on stdout; return what it prints on stderr."""
    monkeypatch.setattr(sys, "argv", ["closecall", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    printed = capsys.readouterr()
    assert (left.value.code, printed.out) == (2, "")
    return printed.err


@pytest.mark.parametrize("item", ITEMS)
def test_bad_input_is_one_line_and_nothing_is_written(
    item: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text, expected = ITEMS[item]
    (folder / "s.yaml").write_text(text)
    before = sorted(folder.rglob("*"))
    told = refused(monkeypatch, capsys, "run", "s.yaml", "-o", "out.mcap")
    assert told == refused(monkeypatch, capsys, "check", "s.yaml")
    (line,) = told.splitlines()
    assert LINE.fullmatch(line)
    assert expected in line
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    ("output", "options", "phrase"),
    [
        ("s.yaml", (), "s.yaml"),
        ("m.obj", (), "m.obj"),
        ("none/out.mcap", (), "none/out.mcap"),
        (".", (), "."),
        ("out.mcap", ("--epoch", "-1"), "give an --epoch of at least 0"),
        ("out.mcap", ("--max-pairs", "2"), "s.yaml:1:1: scene: more than 2 pairs"),
        ("out.mcap", ("--max-bytes", "99"), "s.yaml:1:1: scene: the file is larger than 99 bytes"),
    ],
)
def test_what_the_command_line_gets_wrong_is_one_line_and_nothing_is_written(
    output: str,
    options: tuple[str, ...],
    phrase: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    shape = "shapes: [{mesh: m}]"
    bodies = "".join(f"  b{i}: {{{shape}, motion: {{type: constant, velocity: [{i}, 0, 0]}}}}\n" for i in range(3))
    (folder / "s.yaml").write_text(f"{HEAD}meshes: {{m: {{file: m.obj, units: mm}}}}\nbodies:\n{bodies}")
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    (line,) = refused(monkeypatch, capsys, "run", "s.yaml", "-o", output, *options).splitlines()
    assert phrase in line
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
