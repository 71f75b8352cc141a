"""Whatever bytes come: a mesh reader returns a whole surface or refuses them in one line, soon and in little memory."""

from __future__ import annotations

import io
import random
import struct
import warnings
import zipfile
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import trimesh
from guarded import memory_limited, time_limited
from mesh_files import (
    MODEL_RELATION,
    OBJECT,
    TRIANGLE_AND_SQUARE,
    ascii_ply,
    binary_ply,
    glb_bytes,
    glb_parts,
    model_xml,
    off,
    package,
)
from places import SAMPLES

from closecall.formats.scene.mesh_files.glb import read_glb
from closecall.formats.scene.mesh_files.obj import read_obj
from closecall.formats.scene.mesh_files.off import read_off
from closecall.formats.scene.mesh_files.ply import read_ply
from closecall.formats.scene.mesh_files.stl import read_stl
from closecall.formats.scene.mesh_files.surface import MeshError, Surface
from closecall.formats.scene.mesh_files.threemf import read_3mf

Read = Callable[[bytes], Surface]
INSERTS = (b"9", b"-", b"0", b"\xff", b"nan", b"1e999", b"\0" * 4, b"[", b"{", b'"', b"<", b"\n", b" ", b"9" * 30)
LONGEST_MESSAGE = 400


def mutated(rng: random.Random, data: bytes) -> bytes:
    """Return the data with one to eight things done to it."""
    result = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        if not result:
            break
        place = rng.randrange(len(result))
        match rng.randrange(6):
            case 0:
                result[place] = rng.randrange(256)
            case 1:
                del result[place:]
            case 2:
                result[place:place] = rng.choice(INSERTS)
            case 3:
                del result[place : place + rng.randrange(1, 9)]
            case 4:
                begin = rng.randrange(len(result))
                result[place:place] = result[begin : begin + rng.randrange(1, 40)]
            case _:
                result[place] = rng.choice(b'0123456789-.eE[]{}<>, \n"')
    return bytes(result)


def plain(data: bytes) -> Callable[[random.Random], bytes]:
    return lambda rng: mutated(rng, data)


def body_of(data: bytes, mark: bytes) -> Callable[[random.Random], bytes]:
    """Spare what comes before the end of `mark`, most often: beyond it lies what a header lets in."""
    head, mark, body = data.partition(mark)
    return lambda rng: head + mark + mutated(rng, body)


def glb_of(text: bytes, binary: bytes) -> Callable[[random.Random], bytes]:
    """Spare the container, whose lengths would refuse most changes."""

    def make(rng: random.Random) -> bytes:
        chunks = ((b"JSON", mutated(rng, text)), (b"BIN\0", mutated(rng, binary)))
        body = b"".join(struct.pack("<I4s", len(data), kind) + data for kind, data in chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body

    return make


def package_of(model: str) -> Callable[[random.Random], bytes]:
    """Spare the archive, whose checksums would refuse most changes."""

    def make(rng: random.Random) -> bytes:
        file = io.BytesIO()
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("_rels/.rels", MODEL_RELATION)
            archive.writestr("3D/3dmodel.model", mutated(rng, model.encode()))
        return file.getvalue()

    return make


def sources() -> Iterator[tuple[str, Read, Callable[[random.Random], bytes]]]:
    faces = "property list uchar int vertex_indices\nproperty uchar red\n"
    ascii_file = ascii_ply("3 0 1 2 9\n4 0 1 2 3 9\n", 2, face_properties=faces)
    mixed = binary_ply(TRIANGLE_AND_SQUARE, colour=True)
    alike = binary_ply([(0, 1, 2)] * 3, ">", "int")
    for name, data in (("ascii", ascii_file), ("binary", mixed), ("big-endian", alike)):
        yield f"ply {name}", read_ply, plain(data)
        yield f"ply {name} body", read_ply, body_of(data, b"end_header\n")
    yield "off", read_off, plain(off())
    document, binary = glb_parts((0, 1, 2, 3, 4, 5), 5)
    document["nodes"] = [
        {"children": [1, 2]},
        {"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0.6, 0.8]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
    ]
    whole = glb_bytes(document, binary)
    size = int.from_bytes(whole[12:16], "little")
    yield "glb", read_glb, plain(whole)
    yield "glb chunks", read_glb, glb_of(whole[20 : 20 + size], whole[28 + size :])
    pair = (
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 9 0 0"/></components></object>'
    )
    model = model_xml(OBJECT + pair, '<item objectid="2"/>')
    yield "3mf stored", read_3mf, plain(package(model, method=zipfile.ZIP_STORED))
    yield "3mf deflated", read_3mf, plain(package(model))
    yield "3mf model", read_3mf, package_of(model)
    yield "obj", read_obj, plain(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1/1 2/2/2 -1//3\n")
    yield (
        "stl ascii",
        read_stl,
        plain(
            b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
            b"endloop\nendfacet\nendsolid x\n"
        ),
    )
    yield "stl binary", read_stl, plain(b"x" * 80 + struct.pack("<I12fH", 1, *range(12), 0))


def whole_files() -> Iterator[tuple[str, Read, Callable[[random.Random], bytes]]]:
    """Yield files as programs write them, with some hundred triangles: each change leaves most of one as it was."""
    for name, read in (("near_gears/pinion.obj", read_obj), ("asteroids/small.stl", read_stl)):
        yield name, read, plain((SAMPLES / name).read_bytes())
    ball = trimesh.creation.icosphere(1)
    for kind, read in (("ply", read_ply), ("off", read_off), ("glb", read_glb), ("stl_ascii", read_stl)):
        data = ball.export(file_type=kind)
        assert isinstance(data, bytes | str)
        yield f"ball as {kind}", read, plain(data if isinstance(data, bytes) else data.encode())


def test_a_plain_obj_file_is_read_as_one_that_is_read_line_by_line() -> None:
    """The last line, an indented comment, is what a plain file does not have."""
    make = plain(b"v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nv 0 1 0 1\nvn 0 0 1\nf 1 2 3 4\nf 1/1 2/2 3/3\nf 1//1 2//1 3//1\n")
    rng = random.Random(8)
    for _ in range(3000):
        data = make(rng)
        assert outcome(read_obj, data) == outcome(read_obj, data + b"\n #"), data


def outcome(read: Read, data: bytes) -> object:
    try:
        surface = read(data)
    except MeshError as error:
        return error.message, error.line
    return surface.vertices.tolist(), surface.triangles.tolist(), surface.warnings


@pytest.mark.parametrize(
    ("read", "make"), [pytest.param(read, make, id=name) for name, read, make in (*sources(), *whole_files())]
)
@pytest.mark.parametrize("count", [500, pytest.param(20000, marks=pytest.mark.deep)])
def test_broken_files_are_read_whole_or_refused_in_one_line(
    read: Read, make: Callable[[random.Random], bytes], count: int
) -> None:
    rng = random.Random(7)
    surfaces, messages = 0, []
    with memory_limited(), warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(count):
            data = make(rng)
            try:
                with time_limited():
                    surface = read(data)
            except MeshError as error:
                messages.append(error.message)
                continue
            surfaces += 1
            assert len(surface.triangles) >= 1
            assert surface.triangles.min() >= 0
            assert surface.triangles.max() < len(surface.vertices)
            assert np.isfinite(surface.vertices).all()
    assert surfaces
    assert messages
    assert all(message.isprintable() and len(message) < LONGEST_MESSAGE for message in messages)
