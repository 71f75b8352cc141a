"""GLB: the triangles of the default scene, each where its nodes put it, or the file is refused."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from mesh_files import POINTS, glb_bytes, glb_parts

from closecall.formats.scene.mesh_files.assembly import MOST_PLACEMENTS, MOST_TRIANGLES
from closecall.formats.scene.mesh_files.glb import read_glb
from closecall.formats.scene.mesh_files.surface import MeshError, topology, welded


def corners_of(data: bytes) -> list[list[list[float]]]:
    surface = read_glb(data)
    return surface.vertices[surface.triangles].tolist()


def changed(at: tuple[Any, ...], value: Any, indices: tuple[int, ...] = (0, 1, 2), mode: int = 4) -> bytes:
    """Return a file in whose JSON one place is set; None takes it away."""
    document, binary = glb_parts(indices, mode)
    place: Any = document
    for key in at[:-1]:
        place = place[key]
    if value is None:
        del place[at[-1]]
    else:
        place[at[-1]] = value
    return glb_bytes(document, binary)


def with_nodes(nodes: list[dict[str, Any]], roots: tuple[int, ...] = (0,), **more: Any) -> bytes:
    document, binary = glb_parts()
    return glb_bytes(document | {"nodes": nodes, "scenes": [{"nodes": list(roots)}]} | more, binary)


def points(*indices: int) -> list[list[list[float]]]:
    return [[list(map(float, POINTS[i])) for i in indices[k : k + 3]] for k in range(0, len(indices), 3)]


@pytest.mark.parametrize(
    ("mode", "indices", "triangles"),
    [
        (4, (0, 1, 2, 1, 3, 2), (0, 1, 2, 1, 3, 2)),
        (5, (0, 1, 2, 3), (0, 1, 2, 3, 2, 1)),
        (5, (0, 1, 2, 3, 3, 4, 4, 5, 6), (0, 1, 2, 3, 2, 1, 4, 5, 6)),
        (6, (0, 1, 3, 2), (0, 1, 3, 0, 3, 2)),
    ],
)
def test_lists_strips_and_fans_give_their_triangles_without_stitches(
    mode: int, indices: tuple[int, ...], triangles: tuple[int, ...]
) -> None:
    assert corners_of(glb_bytes(*glb_parts(indices, mode))) == points(*triangles)


def test_a_strip_without_indices_takes_the_vertices_in_order() -> None:
    data = changed(("meshes", 0, "primitives", 0), {"attributes": {"POSITION": 0}, "mode": 6})
    assert len(read_glb(data).triangles) == len(POINTS) - 2


def test_only_used_vertices_are_kept_so_that_strangers_do_not_count() -> None:
    assert read_glb(glb_bytes(*glb_parts((0, 1, 3)))).vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    stray = [*POINTS[:3], (np.nan, 0, 0)]
    assert corners_of(glb_bytes(*glb_parts(points=stray))) == points(0, 1, 2)


def test_nodes_move_turn_and_scale_their_children() -> None:
    half = 0.5**0.5
    data = with_nodes([
        {"translation": [10, 0, 0], "children": [1]},
        {"rotation": [0, 0, half, half], "scale": [2, 3, 4], "children": [2]},  # a quarter turn about z
        {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1], "mesh": 0},
    ])  # fmt: skip
    np.testing.assert_allclose(corners_of(data), [[[-8, 10, 28], [-8, 12, 28], [-11, 10, 28]]], atol=1e-14)


def test_no_axes_are_turned_and_no_unit_is_stated() -> None:
    surface = read_glb(glb_bytes(*glb_parts(points=((1, 2, 3), (4, 5, 6), (7, 8, 10)))))
    assert surface.vertices.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 10]]
    assert surface.unit is None


def test_a_mirrored_mesh_still_faces_outward() -> None:
    ball = trimesh.creation.icosphere(1)
    scene: Any = trimesh.Scene()
    scene.add_geometry(ball, transform=np.diag((-1.0, 2.0, 3.0, 1.0)))
    surface = read_glb(scene.export(file_type="glb"))
    a, b, c = surface.vertices[surface.triangles].swapaxes(0, 1)
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).min() > 0


def test_a_turned_mesh_stays_closed_where_its_vertices_are_doubled() -> None:
    """Exporters double vertices at seams; a matrix product could move the two by different roundings."""
    ball = trimesh.creation.icosphere(3)
    soup = ball.vertices[ball.faces].reshape(-1, 3)
    document, _ = glb_parts()
    document["nodes"][0]["rotation"] = [0.1, 0.7, 0.1, 0.7]
    document["meshes"][0]["primitives"][0] = {"attributes": {"POSITION": 0}}
    document["accessors"][0]["count"] = len(soup)
    document["bufferViews"][0]["byteLength"] = 12 * len(soup)
    surface = read_glb(glb_bytes(document, soup.astype("<f4").tobytes()))
    assert len(surface.vertices) == len(soup)
    assert topology(*welded(surface.vertices, surface.triangles)).solid


@pytest.mark.parametrize(
    ("more", "shift"),
    [
        ({"scene": 1}, 9),
        ({}, 0),
        ({"scene": 0}, 0),
    ],
)
def test_the_default_scene_is_read_or_the_first(more: dict[str, Any], shift: int) -> None:
    document, binary = glb_parts()
    del document["scene"]
    document["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}]
    document["scenes"] = [{"nodes": [0]}, {"nodes": [1]}]
    surface = read_glb(glb_bytes(document | more, binary))
    assert surface.vertices[0].tolist() == [shift, 0, 0]
    expected = () if more else ("holds 2 scenes and names none of them: the first is read",)
    assert surface.warnings == expected


def test_without_scenes_every_root_is_read() -> None:
    document, binary = glb_parts()
    del document["scene"], document["scenes"]
    document["nodes"] = [{"translation": [1, 0, 0], "children": [2]}, {"mesh": 0}, {"mesh": 0}]
    assert corners_of(glb_bytes(document, binary))[0][0] == [1, 0, 0]
    assert len(corners_of(glb_bytes(document, binary))) == 2


def test_interleaved_and_quantized_positions_are_read() -> None:
    document, _ = glb_parts()
    rows = b"".join(struct.pack("<3h6x", *row) for row in ((0, 0, 0), (32767, 0, 0), (0, -32768, 16383)))
    document["accessors"][0] |= {"componentType": 5122, "count": 3, "normalized": True}
    document["accessors"][1] |= {"componentType": 5121, "byteOffset": 1}
    document["bufferViews"] = [
        {"buffer": 0, "byteLength": len(rows), "byteStride": 12},
        {"buffer": 0, "byteOffset": len(rows), "byteLength": 4},
    ]
    document["extensionsRequired"] = ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit"]
    data = glb_bytes(document, rows + bytes((9, 0, 1, 2)))
    assert corners_of(data) == [[[0, 0, 0], [1, 0, 0], [0, -1, 16383 / 32767]]]
    document["accessors"][0]["normalized"] = False
    assert corners_of(glb_bytes(document, rows + bytes((9, 0, 1, 2))))[0][2] == [0, -32768, 16383]


def test_what_is_left_out_is_warned_of() -> None:
    document, binary = glb_parts()
    triangle = document["meshes"][0]["primitives"][0]
    document["meshes"][0]["primitives"] = [triangle | {"mode": 0}, triangle | {"mode": 3}, triangle]
    document["animations"] = [{}]
    assert read_glb(glb_bytes(document, binary)).warnings == (
        "holds lines, which are left out",
        "holds points, which are left out",
        "holds animations, which are left out: its nodes stand as they are written",
    )


PRIMITIVE = ("meshes", 0, "primitives", 0)


@pytest.mark.parametrize(
    ("data", "phrase"),
    [
        (b"", "expected a GLB file"),
        (b"glTF" + struct.pack("<II", 1, 12), "version 1 of GLB"),
        (glb_bytes(*glb_parts())[:-1], "cut short: its header says"),
        (glb_bytes(*glb_parts()) + b"\0", "goes on: its header says"),
        (b"glTF" + struct.pack("<II", 2, 12), "no JSON chunk"),
        (b"glTF" + struct.pack("<III4s", 2, 20, 1, b"JSON"), "a chunk says 1 bytes, the file has 0 left"),
        (b"glTF" + struct.pack("<IIH", 2, 14, 1), "cut short in the head of a chunk"),
        (glb_bytes({}), "asset: Field required"),
        (b"glTF" + struct.pack("<III4s", 2, 24, 4, b"JSON") + b'{"a"', "its JSON: EOF|its JSON: expected"),
        (b"glTF" + struct.pack("<III4s", 2, 100020, 100000, b"JSON") + b"[" * 100000, "its JSON: recursion limit"),
        (changed(("asset", "version"), "1.0"), "glTF '1.0' is not supported"),
        (changed(("nodes", 0, "mesh"), 1), "a mesh 1 is referred to, the file has 1"),
        (changed(("scenes", 0, "nodes"), [1]), "a node 1 is referred to, the file has 1"),
        (changed(("scene",), 1), "scene 1 is to be shown, the file has 1"),
        (changed(("scenes", 0, "nodes"), []), "places no triangles"),
        (changed(("nodes", 0, "children"), [0]), r"nodes\[0\] is in two places"),
        (with_nodes([{"children": [2]}, {"children": [2]}, {"mesh": 0}], (0, 1)), r"nodes\[2\] is in two places"),
        (changed(("nodes", 0, "skin"), 0), r"nodes\[0\]: skinned meshes are not supported"),
        (changed(("nodes", 0, "extensions"), {"EXT_mesh_gpu_instancing": {}}), "EXT_mesh_gpu_instancing is not"),
        (changed(("nodes", 0, "rotation"), [0, 0, 0, 2]), r"nodes\[0\].rotation: expected a quaternion of length 1"),
        (changed(("nodes", 0, "rotation"), [0, 0, 0, 0]), "quaternion of length 1, got 0"),
        (changed(("nodes", 0, "matrix"), [1] * 15), r"nodes\[0\].matrix"),
        (changed(("nodes", 0, "matrix"), [1] * 16), "0, 0, 0, 1 in the last row"),
        (changed(("nodes", 0, "scale"), [1e300, 1, 1]).replace(b"1e+300", b"1e+999"), r"nodes\[0\].scale"),
        (with_nodes([{"scale": [1e300] * 3, "children": [1]}, {"scale": [1e300] * 3, "mesh": 0}]), "not finite"),
        (changed(("extensionsRequired",), ["KHR_draco_mesh_compression"]), "draco_mesh_compression', which is not"),
        (changed(("extensionsRequired",), ["ADOBE_odd"]), "requires the extension 'ADOBE_odd'"),
        (changed((*PRIMITIVE, "extensions"), {"KHR_draco_mesh_compression": {}}), "KHR_draco_mesh_compression is not"),
        (changed((*PRIMITIVE, "targets"), [{"POSITION": 0}]), r"meshes\[0\].primitives\[0\]: morph targets"),
        (changed((*PRIMITIVE, "attributes"), {"NORMAL": 0}), "expected an attribute POSITION"),
        (changed((*PRIMITIVE, "attributes", "POSITION"), 7), "accessor 7 is referred to, the file has 2"),
        (changed((*PRIMITIVE, "mode"), 7), "primitives.*mode"),
        (changed((*PRIMITIVE, "mode"), 0), "places no triangles"),
        (changed(("accessors", 0, "type"), "VEC2"), r"accessors\[0\]: expected the type VEC3"),
        (changed(("accessors", 0, "componentType"), 5125), "expected coordinates as float"),
        (changed(("accessors", 1, "componentType"), 5126), "expected indices as unsigned integers"),
        (changed(("accessors", 0, "sparse"), {"count": 1}), "sparse accessors are not supported"),
        (changed(("accessors", 0, "bufferView"), None), r"accessors\[0\]: expected a buffer view"),
        (changed(("accessors", 0, "count"), 10**12), "1000000000000 values lie beyond"),
        (changed(("accessors", 0, "count"), 0), r"accessors\[0\]: expected at least one value"),
        (changed(("accessors", 1, "count"), 0), r"accessors\[1\]: expected at least one value"),
        (changed(("accessors", 0, "count"), 9), "9 values lie beyond"),
        (changed(("accessors", 0, "byteOffset"), 4), "8 values lie beyond"),
        (changed(("bufferViews", 1, "byteLength"), 99), "lie beyond those of the file"),
        (changed(("bufferViews", 1, "byteOffset"), 10**9), "lie beyond those of the file"),
        (changed(("bufferViews", 0, "extensions"), {"EXT_meshopt_compression": {}}), "meshopt_compression' is not"),
        (changed(("bufferViews", 0, "buffer"), 1), "expected a buffer that the file has"),
        (changed(("buffers", 0, "uri"), "a.bin"), "buffers outside the binary chunk"),
        (glb_bytes(*glb_parts((0, 1, 8))), "index 8 is out of range"),
        (glb_bytes(*glb_parts((0, 1, 2, 3))), "three corners for each triangle, got 4"),
        (glb_bytes(*glb_parts((0, 1), 5)), "at least three corners, got 2"),
        (glb_bytes(*glb_parts((0, 0, 1, 1), 5)), "places no triangles"),
        (glb_bytes(*glb_parts(points=((0, 0, 0), (1, np.inf, 0), (0, 1, 0)))), "a coordinate is not finite"),
        (glb_bytes(glb_parts()[0]), "lie beyond those of the file"),
    ],
)  # fmt: skip
def test_bad_glb_is_refused(data: bytes, phrase: str) -> None:
    with pytest.raises(MeshError, match=phrase) as caught:
        read_glb(data)
    assert caught.value.line is None


def test_a_small_file_cannot_ask_for_any_number_of_triangles() -> None:
    document, binary = glb_parts((0, 1, 2) * 2000)
    primitive = document["meshes"][0]["primitives"][0]
    document["meshes"][0]["primitives"] = [primitive] * (MOST_TRIANGLES // 2000 // 1000 + 1)
    document["nodes"] = [{"mesh": 0}] * 1000
    document["scenes"] = [{"nodes": list(range(1000))}]
    with pytest.raises(MeshError, match=f"expected {MOST_TRIANGLES} at most"):
        read_glb(glb_bytes(document, binary))
    document["meshes"][0]["primitives"] = [primitive | {"mode": 1}] * (MOST_PLACEMENTS // 1000 + 1)
    with pytest.raises(MeshError, match=f"expected {MOST_PLACEMENTS} at most"):
        read_glb(glb_bytes(document, binary))


def test_what_trimesh_writes_is_read_as_it_was() -> None:
    box, ball = trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere(2)
    turn = trimesh.transformations.rotation_matrix(1, (1, 2, 3), (4, 5, 6))
    scene: Any = trimesh.Scene()
    scene.add_geometry(box, node_name="a")
    scene.add_geometry(ball, node_name="b", parent_node_name="a", transform=turn)
    scene.add_geometry(ball, transform=np.diag((-2.0, -2.0, -2.0, 1.0)))
    surface = read_glb(scene.export(file_type="glb"))
    expected = scene.to_geometry()
    np.testing.assert_allclose(
        np.sort(surface.vertices[surface.triangles].reshape(-1, 9), axis=0),
        np.sort(expected.vertices[expected.faces].reshape(-1, 9), axis=0),
        atol=1e-6,
    )
    assert topology(surface.vertices, surface.triangles).solid
