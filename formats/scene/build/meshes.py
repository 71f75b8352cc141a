"""Mesh files to meshes: where they may lie, what they hold, in metres and z up."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ....scheduler.model.scene import Mesh
from ....scheduler.solids.enclosed_space import Doubt, Enclosed, UndecidedError, enclosed_by
from ..grammar.scene import MeshReference
from ..limits import LARGEST_NUMBER, SMALLEST_COORDINATE
from ..mesh_files.obj import read_obj
from ..mesh_files.off import read_off
from ..mesh_files.ply import read_ply
from ..mesh_files.stl import read_stl
from ..mesh_files.surface import MeshError, Surface, Topology, topology, used_only, welded
from ..quantities.units import in_unit, metres, metres_of
from ..text.errors import counted, printable, quoted
from ..text.folder import Folder, FolderError
from ..text.signatures import named_format
from .primitive_meshes import frozen_mesh, scaled_mesh


def _read_3mf(data: bytes) -> Surface:
    from ..mesh_files.threemf import read_3mf  # late: few scenes need an archive and an XML parser

    return read_3mf(data)


def _read_glb(data: bytes) -> Surface:
    from ..mesh_files.glb import read_glb  # late: its schema takes as long to build as a scene's

    return read_glb(data)


_READERS = {
    ".3mf": _read_3mf,
    ".glb": _read_glb,
    ".obj": read_obj,
    ".off": read_off,
    ".ply": read_ply,
    ".stl": read_stl,
}
_OWN_SIGNATURES = {".3mf": "a zip", ".glb": "glTF", ".ply": "PLY", ".stl": "STL"}
"""A word of what `named_format` calls a file that is what its suffix says."""

_SUFFIXES = ", ".join(list(_READERS)[:-1]) + f" or {list(_READERS)[-1]}"


@dataclass(frozen=True, slots=True, eq=False)
class _Content:
    """A mesh file's surface, how it joins, what it encloses, and the SHA-256 (hex) of its bytes."""

    surface: Surface
    topology: Topology
    enclosed: Enclosed
    sha256: str


@dataclass(frozen=True, slots=True, eq=False)
class LoadedMesh:
    """A mesh with the file it comes from.

    Attributes:
        mesh: in m and z up.
        path: absolute, symbolic links resolved.
        sha256: of the file's bytes, hex.
        warnings: what is doubtful about it; each begins with the file's name.
    """

    mesh: Mesh
    path: Path
    sha256: str
    warnings: tuple[str, ...]


class MeshFolder:
    """The mesh files that one scene may refer to; each is read once."""

    def __init__(self, folder: Path, roots: Sequence[Path]) -> None:
        """Take the scene file's folder, and other folders in which meshes may lie."""
        self._folder = Folder(folder, roots)
        self._contents: dict[Path, _Content | MeshError] = {}
        self._meshes: dict[tuple[Path, str, str], Mesh] = {}
        self._scaled: dict[tuple[Mesh, tuple[float, float, float]], Mesh] = {}

    def load(self, name: str, reference: MeshReference, unit: str = "m") -> LoadedMesh:
        """Return the mesh of a reference, one and the same for equal files, units and axes.

        Args:
            name: the mesh's name in the scene.
            reference: the file and how its numbers are meant.
            unit: of lengths in warnings.

        Raises:
            MeshError: the file may not be read, cannot be read, or is no mesh; the message names it.
        """
        try:
            path = self._folder.found(reference.file)
        except FolderError as error:
            raise MeshError(error.message) from error
        content = self._contents.get(path)
        if content is None:
            content = self._contents[path] = _content(path)
        if isinstance(content, MeshError):
            line = "" if content.line is None else f":{content.line}"
            raise MeshError(f"{printable(reference.file)}{line}: {content.message}")
        key = path, reference.units, reference.up
        if key not in self._meshes:
            self._meshes[key] = _mesh(name, reference, content)
        texts = (*_warnings(content), *_measured(content.surface, reference.units, unit))
        warnings = tuple(f"{printable(reference.file)} {text}" for text in texts)
        return LoadedMesh(self._meshes[key], path, content.sha256, warnings)

    def scaled(self, mesh: Mesh, scale: tuple[float, float, float]) -> Mesh:
        """Return the mesh with its x, y, z (in metres and z up) times positive factors, the same one for equal ones."""
        key = mesh, scale
        if key not in self._scaled:
            self._scaled[key] = scaled_mesh(mesh, scale)
        return self._scaled[key]


def _content(path: Path) -> _Content | MeshError:
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        kind = printable(path.suffix) or "a file without suffix"
        return MeshError(f"{kind} is not supported by this version, expected {_SUFFIXES}")
    try:
        if path.exists() and not path.is_file():
            return MeshError("expected a file")
        data = path.read_bytes()
    except OSError as error:
        return MeshError(f"the file cannot be read: {error.strerror or error}")
    try:
        _refuse_mistaken(data, path.suffix.lower())
        surface = reader(data)
    except MeshError as error:
        return error
    vertices = np.where(np.abs(surface.vertices) < SMALLEST_COORDINATE, 0.0, surface.vertices)
    vertices, triangles = used_only(*welded(vertices, surface.triangles))
    if np.abs(vertices).max() > LARGEST_NUMBER:
        return MeshError(f"expected coordinates up to {LARGEST_NUMBER:g}")
    try:
        enclosed = enclosed_by(vertices, triangles)
    except UndecidedError as error:
        return MeshError(f"{error.problem}, {_at(error.triangles, vertices, triangles)}: {error.remedy}")
    joined = replace(surface, vertices=vertices, triangles=triangles)
    return _Content(joined, topology(vertices, triangles), enclosed, hashlib.sha256(data).hexdigest())


def _at(two: tuple[int, int], vertices: FloatArray, triangles: IntArray) -> str:
    """Return where two triangles are, in words: their numbers in the file's order, and a corner in its units."""
    x, y, z = vertices[triangles[two[0], 0]].tolist()
    return f"at triangles {two[0] + 1} and {two[1] + 1} of {len(triangles)} (near {x:.6g}, {y:.6g}, {z:.6g})"


def _refuse_mistaken(data: bytes, suffix: str) -> None:
    """Refuse a file that is of another format than its suffix says.

    Raises:
        MeshError: naming both.
    """
    named = named_format(data)
    if named and (suffix not in _OWN_SIGNATURES or _OWN_SIGNATURES[suffix] not in named):
        raise MeshError(f"the file is {named}, expected {suffix[1:].upper()}")


def _mesh(name: str, reference: MeshReference, content: _Content) -> Mesh:
    stated = content.surface.unit
    if stated not in (None, reference.units):
        file = printable(reference.file)
        raise MeshError(f"{file}: the file's own unit is {quoted(stated)}, the scene says {quoted(reference.units)}")
    points = metres_of(content.surface.vertices, reference.units)
    if reference.up == "y":
        points = np.column_stack((points[:, 0], -points[:, 2], points[:, 1]))
    mesh = frozen_mesh(name, points, content.surface.triangles, content.topology.solid)
    return replace(mesh, solids=content.enclosed.solids)


def _warnings(content: _Content) -> list[str]:
    joined = content.topology
    warnings = list(content.surface.warnings)
    if not joined.solid:
        loose = f"{counted(joined.loose_edges, 'edge does', 'edges do')} not join exactly two triangles"
        closed = len(content.enclosed.solids)
        but = f" but for {counted(closed, 'closed part')}" if closed else ", containment inside it is not seen"
        warnings.append(f"is open: treated as a surface{but} ({loose})")
    elif joined.twisted_edges:
        edges = counted(joined.twisted_edges, "edge")
        warnings.append(f"is of mixed orientation: at {edges} neighbours face opposite ways")
    if joined.flat_triangles:
        warnings.append(f"has {counted(joined.flat_triangles, 'zero-area triangle')}")
    return warnings + _doubts(content)


def _doubts(content: _Content) -> list[str]:
    """Return what is doubtful about what the mesh encloses, each kind once."""
    kinds: dict[str, list[Doubt]] = {}
    for doubt in content.enclosed.doubts:
        kinds.setdefault(doubt.problem, []).append(doubt)
    surface = content.surface
    return [
        f"{problem} ({_at(doubts[0].triangles, surface.vertices, surface.triangles)}"
        + (f", and {counted(len(doubts) - 1, 'more place')})" if len(doubts) > 1 else ")")
        for problem, doubts in kinds.items()
    ]


def _measured(surface: Surface, own_unit: str, unit: str) -> list[str]:
    """Return the warnings that tell of lengths, from the file's own unit into another."""
    lengths = [in_unit(metres(one.length, own_unit), unit) for one in surface.measured]
    return [
        one.text.format(length=f"{length:.3g} {unit}") for one, length in zip(surface.measured, lengths, strict=True)
    ]
