"""Every reader of text names the format of another file in one line."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import sqlite3
import struct
import tarfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from mesh_files import binary_ply
from scene_files import HEAD, MOTION, fault, faults

from closecall.formats.scene.reader import read_scene
from closecall.formats.scene.text.errors import SceneError
from closecall.formats.scene.text.signatures import named_format

TEXT = "closecall: 1\n# Über alles\nv 0 0 0\n" * 400


def mcap() -> bytes:
    out = io.BytesIO()
    writer = Writer(out)
    writer.start()
    writer.finish()
    return out.getvalue()


def archive() -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as made:
        made.writestr("3D/3dmodel.model", TEXT)
    return out.getvalue()


def tar() -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as made:
        made.addfile(tarfile.TarInfo("scene.yaml"))
    return out.getvalue()


def database(folder: Path) -> bytes:
    connection = sqlite3.connect(folder / "recording.db3")
    connection.execute("create table topics (name text)")
    connection.commit()
    connection.close()
    return (folder / "recording.db3").read_bytes()


def numpy_file() -> bytes:
    out = io.BytesIO()
    np.save(out, np.eye(3))
    return out.getvalue()


STL = b"solid made by hand".ljust(80) + struct.pack("<I", 2) + bytes(100)
PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4s2I5B", 13, b"IHDR", 1, 1, 8, 2, 0, 0, 0)

FILES = {
    "MCAP": mcap(),
    "ROS 1 bag": b"#ROSBAG V2.0\n" + struct.pack("<I", 69) + b"\x0d\0\0\0index_pos=" + bytes(60),
    "PNG": PNG,
    "zip": archive(),
    "tar": tar(),
    "gzip": gzip.compress(TEXT.encode()),
    "bzip2": bz2.compress(TEXT.encode()),
    "xz": lzma.compress(TEXT.encode()),
    "NumPy": numpy_file(),
    "binary glTF": b"glTF" + struct.pack("<II", 2, 20) + bytes(8),
    "binary STL": STL,
    "binary PLY": binary_ply(((0, 1, 2), (0, 1, 2, 3))),
    "UTF-16": TEXT.encode("utf-16"),
    "UTF-32": TEXT.encode("utf-32"),
    **{f"UTF-16 of {order}": TEXT.encode(order) for order in ("utf-16-le", "utf-16-be")},
}
EXPECTED = {name: name.partition(" of ")[0] for name in FILES}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_a_scene_of_another_format_is_told_by_its_name(tmp_path: Path, name: str, suffix: str) -> None:
    path = tmp_path / f"scene.{suffix}"
    path.write_bytes(FILES[name])
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    (told,) = map(str, caught.value.faults)
    assert told.startswith(f"{path}:1:1: scene: the file is ")
    assert EXPECTED[name] in told
    assert told.endswith(", expected YAML or JSON in UTF-8")
    assert told.isprintable()


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("layout", ["tum", "euroc", "kitti, period: 1", "csv"])
def test_a_trajectory_of_another_format_is_told_by_its_name(tmp_path: Path, name: str, layout: str) -> None:
    (tmp_path / "path.txt").write_bytes(FILES[name])
    told = fault(tmp_path, f"{MOTION}{{type: file, file: path.txt, layout: {layout}}}")
    assert told.startswith("6:32: bodies.a.motion.file: path.txt: the file is ")
    assert EXPECTED[name] in told
    assert told.endswith(", expected UTF-8 text")


def test_a_file_of_times_of_another_format_is_told_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "path.txt").write_text("1 0 0 0 0 1 0 0 0 0 1 0\n")
    (tmp_path / "times.txt").write_bytes(FILES["gzip"])
    told = fault(tmp_path, f"{MOTION}{{type: file, file: path.txt, layout: kitti, times: times.txt}}")
    assert told == "6:64: bodies.a.motion.times: times.txt: the file is packed with gzip, expected UTF-8 text"


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("suffix", ["obj", "off", "ply", "stl", "glb", "3mf"])
def test_a_mesh_of_another_format_than_its_suffix_is_told_by_its_name(tmp_path: Path, name: str, suffix: str) -> None:
    own = {"binary STL": "stl", "binary PLY": "ply", "binary glTF": "glb", "zip": "3mf"}
    if own.get(name) == suffix:
        return
    (tmp_path / f"m.{suffix}").write_bytes(FILES[name])
    (told,) = faults(tmp_path, f"{HEAD}meshes: {{m: {{file: m.{suffix}, units: m}}}}\nbodies: {{}}")
    assert told.startswith(f"4:20: meshes.m.file: m.{suffix}: the file is ")
    assert EXPECTED[name] in told
    assert told.endswith(f", expected {suffix.upper()}")


def test_a_database_is_told_by_its_name(tmp_path: Path) -> None:
    assert named_format(database(tmp_path)) == "an SQLite database, such as a ROS 2 bag (.db3)"


@pytest.mark.parametrize(
    "begin", ["", "BM", "PAR1: 2\n", "MZ 1\n", "GIF89a", "RIFF", "%PDF-", "ply\n", "#ROSBAG V", "BZh9"]
)
def test_text_is_text_however_it_begins(begin: str) -> None:
    assert named_format((begin + TEXT).encode()) == ""


def test_a_character_on_the_border_of_what_is_looked_at_is_no_fault() -> None:
    for length in range(4090, 4100):
        assert named_format(("x" * length + "€" * 9).encode()) == ""


def test_bytes_of_no_known_format_have_no_name() -> None:
    assert named_format(b"") == named_format(b"\0" * 300) == named_format(b"caf\xe9") == ""
