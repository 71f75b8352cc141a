"""A native scene file, read and checked: the one door through which scenes come in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...scheduler.scene import Body, Mesh, PairRule, Scene, Settings, Shape, least_duration
from .document import Findings
from .errors import Where, in_order, quoted, suggestion
from .grammar import BodyPart, Box, Capsule, MeshReference, MeshShape, PairPart, SceneFile, ShapePart, Sphere
from .loaded import LoadedScene, MeshFile
from .meshes import MeshFolder
from .motions import motion
from .names import Bodies, declared, normal
from .parents import check_parents
from .poses import placement
from .shapes import box_mesh, point_mesh, segment_mesh
from .source import read_bytes, read_document
from .surface import MeshError
from .units import Scale
from .wording import parsed


def read_scene(path: Path, mesh_roots: Sequence[Path] = ()) -> LoadedScene:
    """Read a native scene file, YAML or (by its suffix) JSON.

    Args:
        path: the scene file.
        mesh_roots: folders, besides the scene's own, in which mesh files may lie.

    Returns:
        The scene in SI units and radians, with its warnings.

    Raises:
        SceneError: the file cannot be read or is wrong; it carries every fault found, with line and column.
    """
    source = read_bytes(path)
    document = read_document(source, str(path))
    reading = _Reading(parsed(document), Findings(document), MeshFolder(path.parent, mesh_roots))
    return reading.loaded(path, source)


class _Reading:
    """One reading of a grammatical scene: from the file's values to the scheduler's."""

    def __init__(self, file: SceneFile, findings: Findings, folder: MeshFolder) -> None:
        self._file = file
        self._findings = findings
        self._scale = Scale(file.units.length, file.units.angle)
        self._settings = self._read_settings()
        self._mesh_files: list[MeshFile] = []
        self._meshes = self._read_meshes(folder)
        self._bodies = Bodies(file.bodies, findings)

    def loaded(self, path: Path, source: bytes) -> LoadedScene:
        """Return the whole, or raise SceneError if anything was wrong."""
        bodies = tuple(self._body(name, part) for name, part in self._file.bodies.items())
        check_parents(tuple(self._file.bodies), [body.parent for body in bodies], self._findings)
        scene = Scene(bodies, self._file.time.start, self._file.time.end, self._rules())
        self._findings.stop_if_faulty()
        warnings = tuple(map(str, in_order(self._findings.warnings)))
        return LoadedScene(path, source, scene, self._settings, tuple(self._mesh_files), warnings)

    def _read_settings(self) -> Settings:
        start, end = self._file.time.start, self._file.time.end
        if end <= start:
            problem = f"expected an end after the start ({quoted(start)} s), got {quoted(end)} s"
            self._findings.fault(("time", "end"), problem)
        given = {name: value for name, value in self._file.settings if value is not None}
        spacing = least_duration(start, end)
        settings = Settings(**given)
        for name in ("time_resolution", "contact_tolerance"):
            value = getattr(settings, name)
            if value < spacing:
                where: Where = ("settings", name) if name in given else ("time", "end")
                problem = f"{name} {quoted(value)} s is too short for times near {quoted(end)} s"
                self._findings.fault(where, f"{problem}, expected at least {quoted(spacing)} s")
        return settings

    def _read_meshes(self, folder: MeshFolder) -> dict[str, Mesh | None]:
        """Return the meshes by name, None for one with a fault."""
        written = self._file.meshes
        names = declared("meshes", written, self._findings)
        return {
            name: self._read_mesh(folder, name, ("meshes", key), part)
            for name, (key, part) in zip(names, written.items(), strict=True)
        }

    def _read_mesh(self, folder: MeshFolder, name: str, where: Where, part: MeshReference) -> Mesh | None:
        try:
            loaded = folder.load(name, part)
        except MeshError as error:
            self._findings.fault((*where, "file"), error.message)
            return None
        for warning in loaded.warnings:
            self._findings.warn((*where, "file"), warning)
        self._mesh_files.append(MeshFile(name, loaded.path, loaded.sha256))
        return loaded.mesh

    def _body(self, name: str, part: BodyPart) -> Body:
        where: Where = ("bodies", name)
        parent = None if part.parent is None else self._bodies.index(part.parent, (*where, "parent"))
        shapes = (self._shape(shape, (*where, "shapes", i)) for i, shape in enumerate(part.shapes))
        return Body(
            name=normal(name),
            parent=parent,
            pose=placement(part.pose, (*where, "pose"), self._scale, self._findings).matrix(),
            motion=motion(part.motion, (*where, "motion"), self._file.time, self._scale, self._findings),
            shapes=tuple(shape for shape in shapes if shape is not None),
        )

    def _shape(self, part: ShapePart, where: Where) -> Shape | None:
        """Return the shape, or None if its mesh has a fault or is unknown."""
        pose = placement(part.pose, (*where, "pose"), self._scale, self._findings).matrix()
        match part:
            case Box():
                return Shape(box_mesh(*self._scale.lengths(part.box)), 0.0, pose)
            case Sphere():
                return Shape(point_mesh(), self._scale.length(part.sphere), pose)
            case Capsule():
                length, radius = (
                    self._scale.length(part.capsule.length),
                    self._scale.length(part.capsule.radius),
                )
                return Shape(segment_mesh(length), radius, pose)
            case MeshShape():
                mesh = self._mesh(part.mesh, (*where, "mesh"))
                return None if mesh is None else Shape(mesh, 0.0, pose)

    def _mesh(self, name: str, where: Where) -> Mesh | None:
        key = normal(name)
        if key not in self._meshes:
            near = suggestion(name, self._meshes)
            self._findings.fault(where, f"unknown mesh {quoted(name)}{near}, expected a name from meshes")
        return self._meshes.get(key)

    def _rules(self) -> tuple[PairRule, ...]:
        pairs = self._file.pairs
        ignored = [self._rule(part, ("pairs", "ignore", i), False) for i, part in enumerate(pairs.ignore)]
        checked = [self._rule(part, ("pairs", "check", i), True) for i, part in enumerate(pairs.check)]
        return (*ignored, *checked)

    def _rule(self, part: PairPart, where: Where, check: bool) -> PairRule:
        sides = [(*where, "between", i) for i in range(2)]
        one, other = (self._bodies.matching(name, side) for name, side in zip(part.between, sides, strict=True))
        if one == other and len(one) == 1:
            (index,) = one
            name = quoted(self._bodies.names[index])
            self._findings.fault(sides[1], f"expected two bodies, both sides are the body {name} alone")
        return PairRule(one, other, check)
