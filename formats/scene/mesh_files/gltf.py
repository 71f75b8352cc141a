"""What a glTF document must be for its triangles to be read: the part of its schema that says where they are."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

from ..text.errors import place_text, printable
from .surface import MeshError

POINTS_AND_LINES = frozenset(range(4))
TRIANGLES, STRIP, FAN = 4, 5, 6

Count = Annotated[int, Field(ge=0, lt=2**48)]
Real = Annotated[float, Field(allow_inf_nan=False)]
Quadruple = tuple[Real, Real, Real, Real]
Triple = tuple[Real, Real, Real]


class _Part(BaseModel):
    """An object of glTF; what it holds besides is of no concern."""

    model_config = ConfigDict(alias_generator=to_camel, frozen=True)

    extensions: dict[str, Any] = {}


class Asset(_Part):
    """The version of glTF."""

    version: str


class Buffer(_Part):
    """Bytes, in this file if there is no URI."""

    uri: str | None = None
    byte_length: Count


class View(_Part):
    """A stretch of a buffer."""

    buffer: Count
    byte_offset: Count = 0
    byte_length: Count
    byte_stride: Annotated[int, Field(ge=4, le=252)] | None = None


class Accessor(_Part):
    """Numbers in a stretch of a buffer."""

    buffer_view: Count | None = None
    byte_offset: Count = 0
    component_type: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    normalized: bool = False
    count: Count
    type: str
    sparse: Any = None


class Primitive(_Part):
    """Triangles, lines or points of one mesh."""

    attributes: dict[str, Count]
    indices: Count | None = None
    mode: Annotated[int, Field(ge=0, le=6)] = TRIANGLES
    targets: Any = None


class Mesh(_Part):
    """A list of primitives."""

    primitives: list[Primitive]


class Node(_Part):
    """A frame with a mesh, or none, and other frames in it."""

    children: list[Count] = []
    mesh: Count | None = None
    skin: Any = None
    matrix: Annotated[list[Real], Field(min_length=16, max_length=16)] | None = None
    translation: Triple = (0.0, 0.0, 0.0)
    rotation: Quadruple = (0.0, 0.0, 0.0, 1.0)
    scale: Triple = (1.0, 1.0, 1.0)


class SceneNodes(_Part):
    """The roots of one scene."""

    nodes: list[Count] = []


class Document(_Part):
    """The whole."""

    asset: Asset
    extensions_required: list[str] = []
    buffers: list[Buffer] = []
    buffer_views: list[View] = []
    accessors: list[Accessor] = []
    meshes: list[Mesh] = []
    nodes: list[Node] = []
    scenes: list[SceneNodes] = []
    scene: Count | None = None
    animations: list[Any] = []


def parsed_document(text: bytes) -> Document:
    """Return the document that JSON spells.

    Raises:
        MeshError: it is no JSON or no such document; the message names the place.
    """
    try:
        return Document.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = place_text(first["loc"]) if first["loc"] else "its JSON"
        raise MeshError(f"{printable(place)}: {printable(first['msg']).removeprefix('Invalid JSON: ')}") from error
