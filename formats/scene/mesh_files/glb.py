"""GLB, glTF in one binary file: the triangles that its scene places, in the file's own axes.

trimesh 5.2 loses fans, takes the stitches between a strip's parts for triangles, and loads skinned, morphed and
Draco-compressed meshes, NaN, and indices out of range without a word.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ..limits import ROTATION_ROUNDING, ROTATION_TOLERANCE
from ..text.errors import counted, quoted
from .assembly import Assembly
from .glb_primitives import Primitives
from .gltf import Document, Node, parsed_document
from .surface import MeshError, Surface

_HEADER = struct.Struct("<4sII")
_CHUNK = struct.Struct("<I4s")
_SHAPELESS = re.compile(r"(KHR|EXT|MSFT)_(materials?|texture|lights?|xmp|mesh_quantization)(_\w+)?")
"""Extensions that a file may require and that do not change where its triangles are."""

_INSTANCES = "EXT_mesh_gpu_instancing"


def read_glb(data: bytes) -> Surface:
    """Return the surface of a GLB file's default scene, each mesh where its nodes put it.

    No unit and no axes are implied: what glTF calls metres and y up is whatever the scene file says of the mesh.

    Raises:
        MeshError: the file is cut short or malformed, needs what is not supported, a coordinate is not finite, an
            index is out of range, or there are no triangles.
    """
    text, binary = _chunks(data)
    document = parsed_document(text)
    _refuse_foreign(document)
    primitives = Primitives(document, binary)
    assembly, loose = Assembly(), dict[int, float]()
    for index, transform in _placed_nodes(document):
        node = document.nodes[index]
        off = abs(float(np.linalg.norm(node.rotation)) - 1.0)
        if node.matrix is None and off > ROTATION_ROUNDING:
            loose[index] = off
        if node.skin is not None or _INSTANCES in node.extensions:
            what = f"the extension {_INSTANCES} is" if node.skin is None else "skinned meshes are"
            raise MeshError(f"nodes[{index}]: {what} not supported by this version")
        if node.mesh is not None:
            for vertices, triangles, grid in primitives.of_mesh(node.mesh):
                assembly.place(vertices, triangles, transform, grid)
    warnings = sorted(f"holds {what}, which are left out" for what in primitives.left_out)
    if loose:
        worst = max(loose, key=loose.__getitem__)
        nodes = f"has {counted(len(loose), 'node')} whose quaternion's length is off 1"
        warnings.append(f"{nodes}, by up to {loose[worst]:.2g} in nodes[{worst}]: it is normalised")
    if document.animations:
        warnings.append("holds animations, which are left out: its nodes stand as they are written")
    if document.scene is None and len(document.scenes) > 1:
        warnings.append(f"holds {len(document.scenes)} scenes and names none of them: the first is read")
    return assembly.surface(warnings)


def _chunks(data: bytes) -> tuple[bytes, memoryview]:
    """Return the JSON of the file and its binary chunk, which may be empty."""
    if len(data) < _HEADER.size or data[:4] != b"glTF":
        raise MeshError("expected a GLB file, which begins with 'glTF'")
    _, version, length = _HEADER.unpack_from(data)
    if version != 2:
        raise MeshError(f"version {version} of GLB is not supported, expected 2")
    if length != len(data):
        problem = "is cut short" if length > len(data) else "goes on"
        raise MeshError(f"the file {problem}: its header says {length} bytes, it has {len(data)}")
    found: dict[bytes, memoryview] = {}
    place = _HEADER.size
    while place < length:
        if place + _CHUNK.size > length:
            raise MeshError("the file is cut short in the head of a chunk")
        size, kind = _CHUNK.unpack_from(data, place)
        place += _CHUNK.size
        if place + size > length:
            raise MeshError(f"a chunk says {size} bytes, the file has {length - place} left")
        found.setdefault(kind, memoryview(data)[place : place + size])
        place += size
    if b"JSON" not in found:
        raise MeshError("the file has no JSON chunk")
    return bytes(found[b"JSON"]), found.get(b"BIN\0", memoryview(b""))


def _refuse_foreign(document: Document) -> None:
    """Refuse other versions of glTF, and extensions without which the file says that it cannot be read."""
    if not document.asset.version.startswith("2."):
        raise MeshError(f"glTF {quoted(document.asset.version)} is not supported, expected 2.0")
    for name in document.extensions_required:
        if not _SHAPELESS.fullmatch(name):
            raise MeshError(f"the file requires the extension {quoted(name)}, which is not supported by this version")


def _placed_nodes(document: Document) -> Iterator[tuple[int, FloatArray]]:
    """Yield the nodes of the scene, each with its transform to the scene, a parent before its children.

    No node is taken twice: glTF wants a tree, and a ring of nodes would not end.
    """
    seen: set[int] = set()
    waiting = [(root, np.eye(4)) for root in reversed(_roots(document))]
    while waiting:
        index, parent = waiting.pop()
        if index >= len(document.nodes):
            raise MeshError(f"a node {index} is referred to, the file has {len(document.nodes)}")
        if index in seen:
            raise MeshError(f"nodes[{index}] is in two places of the scene, expected a tree")
        seen.add(index)
        node = document.nodes[index]
        with np.errstate(all="ignore"):
            transform = parent @ _transform(node, index)
        yield index, transform
        waiting += [(child, transform) for child in reversed(node.children)]


def _roots(document: Document) -> list[int]:
    if document.scenes:
        chosen = document.scene or 0
        if chosen >= len(document.scenes):
            raise MeshError(f"scene {chosen} is to be shown, the file has {len(document.scenes)}")
        return document.scenes[chosen].nodes
    children = {child for node in document.nodes for child in node.children}
    return [index for index in range(len(document.nodes)) if index not in children]


def _transform(node: Node, index: int) -> FloatArray:
    """Return the (4, 4) transform from the node to its parent, of column vectors."""
    if node.matrix is not None:
        matrix: FloatArray = np.array(node.matrix).reshape(4, 4).T
        if matrix[3].tolist() != [0, 0, 0, 1]:
            raise MeshError(f"nodes[{index}].matrix: expected 0, 0, 0, 1 in the last row")
        return matrix
    x, y, z, w = node.rotation
    norm = float(np.linalg.norm(node.rotation))
    if not abs(norm - 1) <= ROTATION_TOLERANCE:
        raise MeshError(f"nodes[{index}].rotation: expected a quaternion of length 1, got {norm:g}")
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    turn = np.array((
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ))  # fmt: skip
    matrix = np.eye(4)
    matrix[:3, :3] = turn * node.scale
    matrix[:3, 3] = node.translation
    return matrix
