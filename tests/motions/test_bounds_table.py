"""The table of motion bounds in docs/guarantees.md: a row for each class of motions, and docstrings that cite rows."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from closecall.scheduler import motions

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
HEAD = "| row | pose | displacement D | path length L | rates | source |"
CITED = re.compile(r"\b[Rr]ows? ((?:`[^`]+`(?: and )?)+)")


def table() -> dict[str, list[str]]:
    """Return the cells of each row by its name."""
    lines = (ROOT / "docs" / "guarantees.md").read_text(encoding="utf-8").split("## Motion bounds", 1)[1].splitlines()
    first = lines.index(HEAD) + 2
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[first : lines.index("", first)]]
    assert all(len(row) == 6 for row in rows)
    return {row[0].strip("`"): row[1:] for row in rows}


def docstrings() -> list[tuple[str, str]]:
    """Return the docstrings of the scheduler: the file's name and the text."""
    nodes = [
        (path.name, node)
        for path in sorted((ROOT / "scheduler").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    ]
    return [
        (file, ast.get_docstring(node) or "")
        for file, node in nodes
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    ]


@pytest.mark.parametrize(
    "name",
    [
        name
        for name in motions.__all__
        if isinstance(kind := getattr(motions, name), type) and hasattr(kind, "pose") and kind is not motions.Motion
    ],
)
def test_each_class_of_motions_has_a_row_that_says_how_far_it_gets(name: str) -> None:
    pose, displacement, path_length, rates, _ = table()[name]
    assert pose
    assert displacement
    assert path_length
    assert rates


def test_each_row_that_a_docstring_cites_is_in_the_table() -> None:
    found = [(file, rows) for file, text in docstrings() for rows in CITED.findall(text)]
    cited = [(file, name) for file, rows in found for name in rows.split("`")[1::2]]
    assert len({file for file, _ in cited}) > 8
    assert {name for _, name in cited} <= set(table())
    loose = [file for file, text in docstrings() if re.search(r"\b[Rr]ow '", text)]
    assert not loose, "cite rows of the table as Row `Name`"
