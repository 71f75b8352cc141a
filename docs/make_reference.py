"""Write scene_reference.md: every key of the scene file, from the JSON Schema that `closecall schema` prints.

Run it from anywhere, with closecall installed: python docs/make_reference.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from closecall.formats.scene.schema import schema

REFERENCE = Path(__file__).with_name("scene_reference.md")

INTRODUCTION = """# The scene file, key by key

Made by docs/make_reference.py from the grammar that reads the file; `closecall schema` prints the same as a JSON
Schema. README has the overview. Lengths and angles are in the file's own units, times in seconds.
"""


def kind(field: dict[str, Any]) -> str:
    """Return a value's type in words, a mapping as a link to its own table."""
    if "$ref" in field:
        return link(field["$ref"])
    if "const" in field:
        return f"`{json.dumps(field['const'])}`" if not isinstance(field["const"], str) else f"`{field['const']}`"
    if "enum" in field:
        return " or ".join(f"`{value}`" for value in field["enum"])
    choices = field.get("oneOf") or field.get("anyOf") or field.get("allOf")
    if choices:
        return " or ".join(kind(choice) for choice in choices)
    if field["type"] == "array":
        return array_kind(field)
    if field["type"] == "object":
        return f"mapping of names to {kind(field['additionalProperties'])}"
    return {"boolean": "true or false", "string": "text"}.get(field["type"], "number" + limits(field))


def array_kind(field: dict[str, Any]) -> str:
    """Return the type of a list in words."""
    if "prefixItems" not in field:
        return f"list of {kind(field['items'])}"
    inner = [kind(item) for item in field["prefixItems"]]
    return f"{len(inner)} x {inner[0]}"


def limits(field: dict[str, Any]) -> str:
    """Return what a number must be, beyond what any number of a scene must."""
    least = field.get("minimum")
    if least is None or least < 0.0:
        return ""
    return " >= 0" if least == 0.0 else " > 0"


def link(reference: str) -> str:
    """Return a link to a mapping's table, given its place in the schema."""
    title = heading(reference.rsplit("/", 1)[1])
    return f"[{title}](#{title.lower()})"


def heading(name: str) -> str:
    """Return what a mapping's table is called, given the schema's name for it."""
    return name.removesuffix("Part")


def default_of(field: dict[str, Any]) -> str:
    """Return the default of a key that may be left out: in the words of its description, else as a file writes it."""
    stated = field["description"].partition("Default: ")[2]
    return stated.rstrip(".") or f"`{json.dumps(field['default'], ensure_ascii=False)}`"


def table(definition: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a mapping's table: what it is told by first, then what is required, then the rest."""
    required = definition.get("required", ())
    yield "| key | type | default | |"
    yield "|---|---|---|---|"
    for key, field in sorted(
        definition["properties"].items(), key=lambda one: (one[0] != "type", one[0] not in required)
    ):
        said = field["description"].partition("Default: ")[0].rstrip()
        cells = (f"`{key}`", kind(field), "required" if key in required else default_of(field), said)
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def reference() -> str:
    """Return the whole page."""
    whole = schema()
    lines = [INTRODUCTION]
    for name, definition in {whole["title"]: whole, **in_order(whole)}.items():
        lines += [f"## {heading(name)}", "", definition["description"], "", *table(definition), ""]
    return "\n".join(lines)


def in_order(whole: dict[str, Any]) -> dict[str, Any]:
    """Return the schema's mappings in the order in which the page first speaks of them."""
    found: dict[str, Any] = {}
    todo = [whole]
    while todo:
        for name in referred(todo.pop(0)["properties"]):
            if name not in found:
                found[name] = whole["$defs"][name]
                todo.append(found[name])
    return found


def referred(value: Any) -> Iterator[str]:
    """Yield the names of the mappings that a part of the schema refers to."""
    if isinstance(value, dict):
        if "$ref" in value:
            yield value["$ref"].rsplit("/", 1)[1]
        for key, inner in value.items():
            if key != "discriminator":
                yield from referred(inner)
    if isinstance(value, list):
        for inner in value:
            yield from referred(inner)


if __name__ == "__main__":
    REFERENCE.write_text(reference(), encoding="utf-8", newline="\n")
