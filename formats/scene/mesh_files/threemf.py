"""3MF: the objects that a package builds, each where its transforms put it, in the unit that the package states.

trimesh 5.2 needs two more packages for 3MF, loads NaN and indices out of range without a word, leaves out an object
that is nowhere, and heeds no required extension.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO

import numpy as np

from ....scheduler.geometry.arrays import FloatArray
from ..text.errors import quoted
from .assembly import Assembly, Budget
from .package_xml import read_elements
from .surface import MeshError, Surface
from .threemf_model import Model, ModelObject, ModelReader, Placement

_RELATIONS = "_rels/.rels"
_RELATION = "http://schemas.openxmlformats.org/package/2006/relationships Relationship"
_MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)

LARGEST_PARTS = 2**28
"""Bytes, of all the parts that are read, unpacked, at some 4 to 25 MB/s."""

_ALWAYS_UNPACKED = 2**22
_MOST_EXPANSION = 100
"""Bytes to which a byte of the file may unpack, beyond the first: ZIP allows 1032, models are some 5 to 20."""

_DEEPEST = 32
"""Components within each other. A deeper object is refused."""

_CHUNK = 2**16


def read_3mf(data: bytes) -> Surface:
    """Return the surface of all that a 3MF file builds.

    Raises:
        MeshError: the file is damaged or malformed, needs what is not supported, a number is not finite, an index is
            out of range, or nothing is built.
    """
    package = _Package(data)
    root = package.start()
    unit = package.model(root).unit
    items = [(root, item) for item in package.model(root).items]
    if not items:
        raise MeshError("the file builds nothing, expected an item in its build")
    budget = Budget()
    needs = _Needs(package)
    for part, item in items:
        need = needs.of(part, item)
        budget.spend(need.triangles, need.placements)
    assembly = Assembly()
    waiting = [(part, item, np.eye(4)) for part, item in reversed(items)]
    while waiting:
        part, placement, parent = waiting.pop()
        part, placed = package.placed(part, placement)
        with np.errstate(all="ignore"):
            transform: FloatArray = parent @ placement.transform
        if len(placed.triangles):
            assembly.place(placed.vertices, placed.triangles, transform)
        waiting += [(part, component, transform) for component in reversed(placed.components)]
    return assembly.surface((), unit)


class _Package:
    """The parts of a file, each read when it is first asked for."""

    def __init__(self, data: bytes) -> None:
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(data))
            names = self._archive.namelist()
        except Exception as error:  # whatever the library meets, the file is no such archive
            raise MeshError(f"expected a 3MF package, a ZIP archive: {quoted(error)}") from error
        self._names = {name.lower(): name for name in names}
        if len(self._names) != len(names):
            raise MeshError("two parts of the package have one name")
        self._most = self._left = min(LARGEST_PARTS, _ALWAYS_UNPACKED + _MOST_EXPANSION * len(data))
        self._models: dict[str, Model] = {}

    def start(self) -> str:
        """Return the name of the model part that the package begins with."""
        relations = _RelationReader()
        read_elements(self._chunks(_RELATIONS), _RELATIONS, relations)
        if len(relations.models) != 1:
            raise MeshError(f"{_RELATIONS} names {len(relations.models)} models, expected one")
        return _part_name(relations.models[0])

    def model(self, part: str) -> Model:
        """Return a model part."""
        if part not in self._models:
            reader = ModelReader()
            read_elements(self._chunks(part), part, reader)
            first = next(iter(self._models.values()), reader.model)
            if reader.model.unit != first.unit:
                own, other = quoted(reader.model.unit), quoted(first.unit)
                raise MeshError(f"the unit of {quoted(part)} is {own}, that of the model it belongs to {other}")
            self._models[part] = reader.model
        return self._models[part]

    def placed(self, part: str, placement: Placement) -> tuple[str, ModelObject]:
        """Return the object that a placement in a part speaks of, with the part that has it."""
        holder = part if placement.part is None else _part_name(placement.part)
        found = self.model(holder).objects.get(placement.object_id)
        if found is None:
            raise MeshError(f"{quoted(holder)} has no object {quoted(placement.object_id)}, which is to be placed")
        return holder, found

    def _chunks(self, part: str) -> Iterator[bytes]:
        """Yield the bytes of a part as they are unpacked."""
        name = self._names.get(part.lower())
        if name is None:
            raise MeshError(f"the package has no part {quoted(part)}")
        if self._archive.getinfo(name).compress_type not in _METHODS:
            raise MeshError(f"{quoted(part)} is packed by a method that 3MF does not know")
        try:
            stream = self._archive.open(name)
        except Exception as error:  # whatever the library meets, the part cannot be read
            raise MeshError(f"{quoted(part)} cannot be unpacked: {quoted(error)}") from error
        with stream:
            while chunk := self._read(stream, part):
                self._left -= len(chunk)
                if self._left < 0:
                    raise MeshError(f"the parts unpack to more than {self._most} bytes")
                yield chunk

    @staticmethod
    def _read(stream: IO[bytes], part: str) -> bytes:
        try:
            return stream.read(_CHUNK)
        except Exception as error:  # a checksum, a broken stream
            raise MeshError(f"{quoted(part)} cannot be unpacked: {quoted(error)}") from error


class _RelationReader:
    """Takes the relationships of a package."""

    def __init__(self) -> None:
        self.models: list[str] = []

    def declare(self, prefix: str, namespace: str) -> None:
        """Take the namespace that a prefix stands for, which names hold already."""

    def begin(self, name: str, attributes: dict[str, str]) -> None:
        """Take the begin of an element."""
        if name == _RELATION and attributes.get("Type") == _MODEL_TYPE:
            self.models.append(attributes.get("Target", ""))

    def end(self) -> None:
        """Take the end of an element."""


def _part_name(target: str) -> str:
    return target.removeprefix("/")


@dataclass(frozen=True, slots=True)
class _Need:
    """How many triangles and placements it takes to place an object."""

    triangles: int
    placements: int


class _Needs:
    """What it takes to place each object, found without placing any: a few objects can ask for any number."""

    def __init__(self, package: _Package) -> None:
        self._package = package
        self._known: dict[tuple[str, str], _Need] = {}
        self._open: list[tuple[str, str]] = []

    def of(self, part: str, placement: Placement) -> _Need:
        """Return the need of a placement.

        Raises:
            MeshError: an object is part of itself, is nowhere, or components are nested too deep.
        """
        part, placed = self._package.placed(part, placement)
        key = part, placement.object_id
        if key in self._open:
            raise MeshError(f"object {quoted(placement.object_id)} of {quoted(part)} is a component of itself")
        if len(self._open) >= _DEEPEST:
            raise MeshError(f"components are nested deeper than {_DEEPEST}")
        if key not in self._known:
            self._open.append(key)
            needs = [self.of(part, component) for component in placed.components]
            self._open.pop()
            triangles = len(placed.triangles) + sum(need.triangles for need in needs)
            self._known[key] = _Need(triangles, 1 + sum(need.placements for need in needs))
        return self._known[key]
