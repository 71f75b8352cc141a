"""One model part of a 3MF package: its objects and what it builds."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, field

import numpy as np

from ....scheduler.geometry.arrays import FloatArray, IntArray
from ..text.errors import quoted
from .assembly import MOST_PLACEMENTS
from .surface import MeshError, used_only

_UNITS = {"micron": "micron", "millimeter": "mm", "centimeter": "cm", "inch": "in", "foot": "ft", "meter": "m"}
"""The units of 3MF, by the names that a scene file has for them; it has none for a micron."""

_MAKER = "http://schemas.microsoft.com/3dmanufacturing"
_CORES = frozenset((f"{_MAKER}/core/2015/02", f"{_MAKER}/2013/01"))
_PRODUCTION = f"{_MAKER}/production/2015/06"
_MAY_BE_REQUIRED = _CORES | {_PRODUCTION, f"{_MAKER}/material/2015/02", f"{_MAKER}/trianglesets/2021/07"}
"""Extensions that a file may require: production is read, the others do not change where triangles are."""

_FOREIGN = "?"
"""What elements of other namespaces are called in a path."""

_Attributes = dict[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """An object placed by the build or by another object.

    Attributes:
        part: the model part that has the object, None for the one that places it.
        object_id: its id there.
        transform: (4, 4) of column vectors, placing_from_object.
    """

    part: str | None
    object_id: str
    transform: FloatArray


@dataclass(slots=True, eq=False)
class ModelObject:
    """An object: a mesh with (n, 3) vertices and (m, 3) triangles, or placements of other objects."""

    vertices: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    triangles: IntArray = field(default_factory=lambda: np.empty((0, 3), dtype=np.int64))
    components: list[Placement] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class Model:
    """A model part: its unit as a scene file spells it, its objects by id, and what it builds."""

    unit: str = "mm"
    objects: dict[str, ModelObject] = field(default_factory=dict)
    items: list[Placement] = field(default_factory=list)


class ModelReader:
    """Takes the elements of a model part one by one; those of foreign namespaces are passed over."""

    def __init__(self) -> None:
        self.model = Model()
        self._namespaces: dict[str, str] = {}
        self._steps: dict[str, str] = {}
        self._path: tuple[str, ...] = ()
        self._object = ModelObject()
        self._coordinates = array("d")
        self._corners = array("q")
        self._things = 0
        shape = ("model", "resources", "object")
        self._begins = {
            ("model",): self._begin_model,
            shape: self._begin_object,
            (*shape, "mesh", "vertices", "vertex"): self._vertex,
            (*shape, "mesh", "triangles", "triangle"): self._triangle,
            (*shape, "components", "component"): self._component,
            ("model", "build", "item"): self._item,
        }

    def declare(self, prefix: str, namespace: str) -> None:
        """Take the namespace that a prefix stands for."""
        self._namespaces[prefix] = namespace

    def begin(self, name: str, attributes: _Attributes) -> None:
        """Take the begin of an element."""
        step = self._steps.get(name) or self._step(name)
        self._path = (*self._path, step)
        if self._path[0] != "model":
            raise MeshError(f"expected a 3MF model, got {quoted(name)}")
        act = self._begins.get(self._path)
        if act is not None:
            act(attributes)

    def _step(self, name: str) -> str:
        """Return an element's name in the path: without its namespace, which is 3MF's own, or that of all others."""
        namespace, _, local = name.rpartition(" ")
        if local == "beamlattice":
            raise MeshError("beam lattices are not supported by this version")
        self._steps[name] = local if namespace in _CORES else _FOREIGN
        return self._steps[name]

    def end(self) -> None:
        """Take the end of an element."""
        if self._path == ("model", "resources", "object", "mesh"):
            self._end_mesh()
        self._path = self._path[:-1]

    def _begin_model(self, attributes: _Attributes) -> None:
        unit = attributes.get("unit", "millimeter")
        if unit not in _UNITS:
            raise MeshError(f"expected a unit among {', '.join(_UNITS)}, got {quoted(unit)}")
        self.model.unit = _UNITS[unit]
        for prefix in attributes.get("requiredextensions", "").split():
            namespace = self._namespaces.get(prefix, prefix)
            if namespace not in _MAY_BE_REQUIRED:
                what = f"the file requires the extension {quoted(namespace)}"
                raise MeshError(f"{what}, which is not supported by this version")

    def _begin_object(self, attributes: _Attributes) -> None:
        self._count()
        name = attributes.get("id", "")
        if not name or name in self.model.objects:
            raise MeshError(f"expected an object with an id of its own, got {quoted(name)}")
        self._object = self.model.objects[name] = ModelObject()
        self._coordinates, self._corners = array("d"), array("q")

    def _count(self) -> None:
        """Count one more object or placement."""
        self._things += 1
        if self._things > MOST_PLACEMENTS:
            raise MeshError(f"the model has more than {MOST_PLACEMENTS} objects, components and items")

    def _vertex(self, attributes: _Attributes) -> None:
        self._coordinates.extend([_number(attributes.get(axis, "")) for axis in ("x", "y", "z")])

    def _triangle(self, attributes: _Attributes) -> None:
        self._corners.extend([_index(attributes.get(corner, "")) for corner in ("v1", "v2", "v3")])

    def _end_mesh(self) -> None:
        vertices: FloatArray = np.array(self._coordinates, dtype=np.float64).reshape(-1, 3)
        triangles: IntArray = np.array(self._corners, dtype=np.int64).reshape(-1, 3)
        if not len(triangles):
            raise MeshError("the mesh has no triangles, expected at least one")
        if triangles.max() >= len(vertices):
            raise MeshError(f"a triangle refers to vertex {triangles.max()}, the mesh has {len(vertices)}")
        self._object.vertices, self._object.triangles = used_only(vertices, triangles)

    def _component(self, attributes: _Attributes) -> None:
        self._count()
        self._object.components.append(_placement(attributes))

    def _item(self, attributes: _Attributes) -> None:
        self._count()
        self.model.items.append(_placement(attributes))


def _placement(attributes: _Attributes) -> Placement:
    transform = np.eye(4)
    if "transform" in attributes:
        words = attributes["transform"].split()
        if len(words) != 12:
            raise MeshError(f"expected a transform of 12 numbers, got {len(words)}")
        transform[:3] = np.array([_number(word) for word in words]).reshape(4, 3).T
    return Placement(attributes.get(f"{_PRODUCTION} path"), attributes.get("objectid", ""), transform)


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or "_" in text:
        raise MeshError(f"expected a finite number, got {quoted(text)}")
    return value


def _index(text: str) -> int:
    word = text.strip()
    if not (word.isascii() and word.isdigit() and len(word) <= 18):
        raise MeshError(f"expected the index of a vertex, got {quoted(text)}")
    return int(word)
