"""A scene file's bytes, and the document they spell."""

from __future__ import annotations

from pathlib import Path

from .document import Document, refuse
from .json_document import read_json
from .signatures import named_format
from .yaml_document import read_yaml


def read_bytes(path: Path, most: int) -> bytes:
    """Return the bytes of a scene file.

    Raises:
        SceneError: it is missing, unreadable or larger than `most` bytes.
    """
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        refuse(str(path), (1, 1), (), f"the file cannot be read: {reason}")
    if len(data) > most:
        refuse(str(path), (1, 1), (), f"the file is larger than {most} bytes, split it or allow more with --max-bytes")
    return data


def read_document(data: bytes, file: str) -> Document:
    """Parse the bytes of a scene file: JSON when its name ends in `.json`, else YAML.

    Raises:
        SceneError: with the position of what cannot be read.
    """
    text = _decoded(data, file)
    return read_json(text, file) if file.lower().endswith(".json") else read_yaml(text, file)


def _decoded(data: bytes, file: str) -> str:
    named = named_format(data)
    if named:
        refuse(file, (1, 1), (), f"the file is {named}, expected YAML or JSON in UTF-8")
    try:
        return data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        begin = data.rfind(b"\n", 0, error.start) + 1
        column = len(data[begin : error.start].decode("utf-8")) + 1
        byte = data[error.start]
        refuse(
            file,
            (line, column),
            (),
            f"the byte 0x{byte:02X} is not UTF-8, expected YAML or JSON text",
        )
