"""Names of other people's scenes and logs, as each format that leaves the program wants them."""

from __future__ import annotations

import json
from html import escape
from typing import Any

from ...scene.text.errors import printable

# Spreadsheets take a cell that begins so for a formula, the wide forms in some countries. The apostrophe is their own
# mark of a text; it is among them so that one is always taken off again.
_FORMULA = tuple("=+-@＝＋－＠'")


def json_text(value: Any) -> str:
    """Return a value as one line of JSON: UTF-8, but characters that do not print as their numbers.

    Raises:
        ValueError: for NaN and infinite numbers.
    """
    text = json.dumps(value, ensure_ascii=False, allow_nan=False)
    return text if text.isprintable() else "".join(c if c.isprintable() else json.dumps(c)[1:-1] for c in text)


def csv_text(text: str) -> str:
    """Return text as a cell of CSV: one line that prints, and that no spreadsheet takes for a formula."""
    shown = printable(text)
    return f"'{shown}" if shown.lstrip().startswith(_FORMULA) else shown


def html_text(text: str) -> str:
    """Return text as HTML, without what turns the direction of writing or does not print."""
    return escape(printable(text))
