"""Shapes as written to the scheduler's shapes, and the mesh files that they show."""

from __future__ import annotations

from collections.abc import Mapping

from ....scheduler.model.scene import Mesh, Shape
from ..grammar.scene import MeshReference
from ..grammar.shapes import Box, Capsule, Cone, Cylinder, Ellipsoid, MeshShape, ShapePart, Sphere
from ..loaded import InputFile
from ..mesh_files.surface import MeshError
from ..quantities.poses import placement
from ..quantities.units import Scale
from ..text.document import Findings
from ..text.errors import Where, quoted
from .meshes import MeshFolder
from .names import declared, normal
from .primitive_meshes import box_mesh, point_mesh, segment_mesh
from .round_meshes import RoundMesh, cone_mesh, cylinder_mesh, ellipsoid_mesh


class ShapeReader:
    """The meshes of one scene, read once, and its shapes one by one.

    Attributes:
        files: the mesh files, in document order.
        shown: the meshes of those files that shapes show, each with its key in the scene's `meshes`.
    """

    def __init__(
        self, meshes: Mapping[str, MeshReference], folder: MeshFolder, scale: Scale, findings: Findings
    ) -> None:
        """Read the mesh files; what is wrong with one is recorded."""
        self._scale = scale
        self._findings = findings
        self._folder = folder
        self.files: list[InputFile] = []
        self.shown: dict[Mesh, str] = {}
        self._keys = {normal(key): key for key in meshes}
        self._meshes = {
            name: self._read_mesh(name, ("meshes", key), part)
            for name, (key, part) in zip(declared("meshes", meshes, findings), meshes.items(), strict=True)
        }

    def shape(self, part: ShapePart, where: Where) -> Shape | None:
        """Return a shape, or None if its mesh has a fault or is unknown."""
        pose = placement(part.pose, (*where, "pose"), self._scale, self._findings).matrix()
        match part:
            case Box():
                return Shape(box_mesh(*self._scale.lengths(part.box)), 0.0, pose)
            case Sphere():
                return Shape(point_mesh(), self._scale.length(part.sphere), pose)
            case Capsule():
                length, radius = self._scale.length(part.capsule.length), self._scale.length(part.capsule.radius)
                return Shape(segment_mesh(length), radius, pose)
            case MeshShape():
                mesh = self._mesh(part, (*where, "mesh"))
                return None if mesh is None else Shape(mesh, 0.0, pose)
            case Cylinder() | Cone() | Ellipsoid():
                outside = self._circumscribed(part)
                return Shape(outside.mesh, 0.0, pose, outside.chord_error, outside.solid)

    def _circumscribed(self, part: Cylinder | Cone | Ellipsoid) -> RoundMesh:
        length = self._scale.length
        match part:
            case Cylinder():
                return cylinder_mesh(length(part.cylinder.radius), length(part.cylinder.length))
            case Cone():
                return cone_mesh(length(part.cone.radius), length(part.cone.length))
            case Ellipsoid():
                return ellipsoid_mesh(*self._scale.lengths(part.ellipsoid))

    def _read_mesh(self, name: str, where: Where, part: MeshReference) -> Mesh | None:
        try:
            loaded = self._folder.load(name, part, self._scale.length_unit)
        except MeshError as error:
            self._findings.fault((*where, "file"), error.message)
            return None
        for warning in loaded.warnings:
            self._findings.warn((*where, "file"), warning)
        self.files.append(InputFile(name, loaded.path, loaded.sha256))
        return loaded.mesh

    def _mesh(self, part: MeshShape, where: Where) -> Mesh | None:
        key = normal(part.mesh)
        if key not in self._meshes:
            near = self._findings.suggestion(part.mesh, self._meshes)
            self._findings.fault(where, f"unknown mesh {quoted(part.mesh)}{near}, expected a name from meshes")
        mesh = self._meshes.get(key)
        if mesh is None:
            return None
        each = part.scale if isinstance(part.scale, tuple) else (part.scale, part.scale, part.scale)
        scaled = self._folder.scaled(mesh, each)
        self.shown.setdefault(scaled, self._keys[key])
        return scaled
