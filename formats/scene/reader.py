"""A native scene file, read and checked: the one door through which scenes come in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ...scheduler.model.body_tree import topological_order
from ...scheduler.model.scene import Body, Scene, Settings, least_duration
from ...scheduler.motions import Interval
from .build.existence import existence, needed_times
from .build.meshes import MeshFolder
from .build.motions import MotionReader
from .build.names import Bodies, normal
from .build.parents import check_parents
from .build.rules import pair_rules
from .build.shapes import ShapeReader
from .build.sizes import check_sizes
from .grammar.scene import BodyPart, SceneFile
from .grammar.wording import parsed
from .limits import LARGEST_DOCUMENT, SMALLEST_SIZE
from .loaded import KeyNames, LoadedScene
from .quantities.loose_rotations import warn_of_loose_rotations
from .quantities.poses import placement
from .quantities.units import Scale
from .text.document import Findings
from .text.errors import Where, in_order, quoted
from .text.folder import Folder
from .text.source import read_bytes, read_document


def read_scene(path: Path, mesh_roots: Sequence[Path] = (), max_bytes: int = LARGEST_DOCUMENT) -> LoadedScene:
    """Read a native scene file, YAML or (by its suffix) JSON.

    Args:
        path: the scene file.
        mesh_roots: folders, besides the scene's own, in which the files it names may lie.
        max_bytes: a larger scene file is refused.

    Returns:
        The scene in SI units and radians, with its warnings.

    Raises:
        SceneError: the file cannot be read or is wrong; it carries every fault found, with line and column.
    """
    source = read_bytes(path, max_bytes)
    document = read_document(source, str(path))
    folder, meshes = Folder(path.parent, mesh_roots), MeshFolder(path.parent, mesh_roots)
    return _Reading(parsed(document), Findings(document), folder, meshes).loaded(path, source)


class _Reading:
    """One reading of a grammatical scene: from the file's values to the scheduler's."""

    def __init__(self, file: SceneFile, findings: Findings, folder: Folder, meshes: MeshFolder) -> None:
        self._file = file
        self._findings = findings
        self._scale = Scale(file.units.length, file.units.angle)
        self._settings = self._read_settings()
        self._shapes = ShapeReader(file.meshes, meshes, self._scale, findings)
        self._bodies = Bodies(file.bodies, findings)
        self._motions = MotionReader(folder, self._scale, findings, (file.time.start, file.time.end))

    def loaded(self, path: Path, source: bytes) -> LoadedScene:
        """Return the whole, or raise SceneError if anything was wrong."""
        time = self._file.time
        bodies = self._read_bodies()
        rules = pair_rules(self._file.pairs, self._bodies, self._scale, self._findings)
        self._findings.stop_if_faulty()
        scene = Scene(bodies, time.start, time.end, rules)
        check_sizes(scene, tuple(self._file.bodies), self._shapes.shown, self._findings)
        warn_of_loose_rotations(scene, tuple(self._file.bodies), self._scale.length_unit, self._findings)
        self._findings.stop_if_faulty()
        return LoadedScene(
            path=path,
            source=source,
            scene=scene,
            settings=self._settings,
            mesh_files=tuple(self._shapes.files),
            warnings=tuple(map(str, in_order(self._findings.warnings))),
            trajectory_files=self._motions.files,
            key_names=_nearest_key_names(bodies, self._motions.key_names),
            length_unit=self._scale.length_unit,
        )

    def _read_settings(self) -> Settings:
        start, end = self._file.time.start, self._file.time.end
        if end - start < SMALLEST_SIZE:
            least = f" by at least {SMALLEST_SIZE:g} s" if end > start else ""
            problem = f"expected an end after the start ({quoted(start)} s){least}, got {quoted(end)} s"
            self._findings.fault(("time", "end"), problem)
        given = {name: value for name, value in self._file.settings if value is not None}
        if "margin" in given:
            given["margin"] = self._scale.length(given["margin"])
        if given.get("distance_tolerance") == "none":
            given["distance_tolerance"] = None
        spacing = least_duration(start, end)
        given.setdefault("contact_tolerance", max(Settings().contact_tolerance, spacing))
        settings = Settings(**given)
        for name in ("time_resolution", "contact_tolerance"):
            value = getattr(settings, name)
            if value < spacing:
                where: Where = ("settings", name) if name in given else ("time", "end")
                problem = f"{name} {quoted(value)} s is too short for times near {quoted(end)} s"
                self._findings.fault(where, f"{problem}, expected at least {quoted(spacing)} s")
        return settings

    def _read_bodies(self) -> tuple[Body, ...]:
        time, parts = self._file.time, self._file.bodies
        parents = [self._parent(name, part) for name, part in parts.items()]
        check_parents(tuple(parts), parents, self._findings)
        exists = [existence(name, part, time, self._findings) for name, part in parts.items()]
        needed = needed_times(parents, exists, time)
        return tuple(
            self._body(name, part, parent, there, frame)
            for (name, part), parent, there, frame in zip(parts.items(), parents, exists, needed, strict=True)
        )

    def _parent(self, name: str, part: BodyPart) -> int | None:
        return None if part.parent is None else self._bodies.index(part.parent, ("bodies", name, "parent"))

    def _body(self, name: str, part: BodyPart, parent: int | None, exists: Interval, needed: Interval) -> Body:
        where: Where = ("bodies", name)
        shapes = (self._shapes.shape(shape, (*where, "shapes", i)) for i, shape in enumerate(part.shapes))
        return Body(
            name=normal(name),
            parent=parent,
            pose=placement(part.pose, (*where, "pose"), self._scale, self._findings).matrix(),
            motion=self._motions.motion(part.motion, name, needed),
            shapes=tuple(shape for shape in shapes if shape is not None),
            exists=exists,
        )


def _nearest_key_names(bodies: tuple[Body, ...], named: Mapping[str, KeyNames]) -> dict[int, KeyNames]:
    """Return the key names that tell of each body: its own, else those of the nearest ancestor with any."""
    found: dict[int, KeyNames] = {}
    if named:
        for index in topological_order(bodies):
            parent = bodies[index].parent
            names = named.get(bodies[index].name) or (None if parent is None else found.get(parent))
            if names is not None:
                found[index] = names
    return found
