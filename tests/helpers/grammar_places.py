"""Places of the scene file's grammar: every key of every mapping, left out or not, every word and form of its value.

A place is written as `Box.pose.rpy`, `ProfileMotion.kind = slide`, `Key.name left out`.
"""

from __future__ import annotations

from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel


def possible(model: type[BaseModel]) -> set[str]:
    """Return every place that a mapping of the grammar, and what may stand in it, has."""
    return {place for part in parts(model) for place in own_places(part)}


def parts(model: type[BaseModel]) -> list[type[BaseModel]]:
    """Return the mappings that may stand in a mapping of the grammar, itself the first, each once."""
    found = [model]
    for part in found:  # grows
        for info in part.model_fields.values():
            found += [arm for arm in leaves(info.annotation) if is_part(arm) and arm not in found]
    return found


def own_places(part: type[BaseModel]) -> Iterator[str]:
    """Yield the places of one mapping's own keys."""
    for field, info in part.model_fields.items():
        place = f"{part.__name__}.{info.alias or field}"
        yield place
        if not info.is_required():
            yield f"{place} left out"
        found = leaves(info.annotation)
        for arm in found:
            if get_origin(arm) is Literal:
                yield from (f"{place} = {word}" for word in get_args(arm))
            elif arm is bool:
                yield from (f"{place} = {word}" for word in (False, True))
            elif len(found) > 1:
                yield f"{place}: {form(arm)}"


def leaves(annotation: Any) -> list[Any]:
    """Return what stands at an annotation: each arm of a union, and of a sequence or mapping of equals its values.

    None is left out: what a scene file does not say it leaves out.
    """
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return leaves(inner[0])
    if origin in (Union, UnionType):
        return [leaf for arm in inner for leaf in leaves(arm)]
    if origin is dict:
        return leaves(inner[1])
    if origin is tuple and inner[-1] is Ellipsis:
        return leaves(inner[0])
    return [] if annotation is NoneType else [annotation]


def is_part(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def form(annotation: Any) -> str:
    """Return how a place names one of several forms of its value: the mapping, or how many numbers."""
    if get_origin(annotation) is tuple:
        return f"{len(get_args(annotation))} values"
    return str(annotation.__name__)


def taken(part: BaseModel) -> set[str]:
    """Return the places that one mapping, as it was read, has taken with its own keys."""
    found: set[str] = set()
    for field, info in type(part).model_fields.items():
        place = f"{type(part).__name__}.{info.alias or field}"
        if field not in part.model_fields_set:
            found.add(f"{place} left out")
            continue
        found.add(place)
        kinds = leaves(info.annotation)
        words = [word for kind in kinds if get_origin(kind) is Literal for word in get_args(kind)]
        for value in values(getattr(part, field), info.annotation):
            if isinstance(value, bool) or value in words:
                found.add(f"{place} = {value}")
            elif len(kinds) > 1:
                name = f"{len(value)} values" if isinstance(value, tuple) else type(value).__name__
                found.add(f"{place}: {name}")
    return found


def values(value: Any, annotation: Any) -> list[Any]:
    """Return the values that stand where `leaves` has the leaves of an annotation."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return values(value, inner[0])
    if origin is dict:
        return [one for item in value.values() for one in values(item, inner[1])]
    if origin is tuple and inner[-1] is Ellipsis:
        return [one for item in value for one in values(item, inner[0])]
    return [] if value is None else [value]


def within(part: BaseModel) -> Iterator[BaseModel]:
    """Yield a mapping as it was read, and all that stand in it."""
    yield part
    for field, info in type(part).model_fields.items():
        for value in values(getattr(part, field), info.annotation):
            if isinstance(value, BaseModel):
                yield from within(value)
