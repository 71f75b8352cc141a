"""CONTRIBUTING.md: the places that it names exist, and hold what there is already of each kind."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Collection
from pathlib import Path

import pytest
from floors import FLOORS
from grammar_places import leaves

from closecall.cli.group import COMMANDS
from closecall.formats.log.container.checks import TYPES
from closecall.formats.log.filters import TOPICS
from closecall.formats.log.tables.tables import tables
from closecall.formats.scene.build.meshes import _READERS
from closecall.formats.scene.grammar.motions import MOTIONS, MotionChoice
from closecall.formats.scene.grammar.shapes import SHAPES, ShapePart
from closecall.scheduler import motions
from closecall.scheduler.model.events import Bound

ROOT = next(folder for folder in Path(__file__).resolve().parents if (folder / "pyproject.toml").exists())
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
PLACE = re.compile(r"`((?:\w+/)+[\w.]*|\w+\.md)`")
ITEM = re.compile(r"^(?=\d+\. )", re.MULTILINE)

CLASSES = [name for name in motions.__all__ if hasattr(getattr(motions, name), "rounding_scale") and name != "Motion"]
MOTION_PARTS = [part.__name__ for part in leaves(MotionChoice)]
SHAPE_PARTS = [part.__name__ for part in leaves(ShapePart)]
SUFFIXES = [suffix[1:] for suffix in _READERS]
BOUNDS = [bound.value for bound in Bound if bound.value]
FACTS = [topic for topic in TOPICS if topic.split("/")[1] in ("windows", "wakeups", "distances", "collisions", "spans")]


def word(name: str) -> str:
    return rf"(?<!\w){re.escape(name)}(?!\w)"


def literal(name: str) -> str:
    return rf'"{re.escape(name)}"'


def code(name: str) -> str:
    return rf"`{re.escape(name)}\b"


def spelt(name: str) -> str:
    """A format in capitals or small letters, with or without a dot."""
    return rf"(?i)(?<![a-z]){re.escape(name)}(?![a-z])"


HELD: dict[str, dict[str, tuple[Collection[str], Callable[[str], str]]]] = {
    "A motion": {
        "scheduler/motions/__init__.py": (CLASSES, literal),
        "docs/guarantees.md": (CLASSES, code),
        "formats/scene/grammar/motions.py": (MOTIONS, lambda name: rf'Tag\("{name}"\)'),
        "formats/scene/build/motions.py": (MOTION_PARTS, word),
        "tests/helpers/rounding_cases.py": ([name for name in CLASSES if name not in ("Fixed", "Limits")], word),
        "tests/helpers/drawn_motions.py": ([name for name in CLASSES if name not in ("Fixed", "Limits")], word),
        "tests/oracle/draw_motions.py": (MOTIONS, lambda name: rf"^def {name}\("),
        "README.md": (MOTIONS, lambda name: rf"^\| `{name}` \|"),
        "docs/scene_reference.md": (MOTIONS, code),
        "sample_scenes/closecall.schema.json": (MOTIONS, literal),
    },
    "A shape": {
        "formats/scene/grammar/shapes.py": (SHAPES, lambda name: rf'Tag\("{name}"\)'),
        "formats/scene/build/shapes.py": (SHAPE_PARTS, word),
        "tests/oracle/draw.py": (SHAPES, literal),
        "README.md": (SHAPES, lambda name: rf"^\|.*`{name}: "),
        "docs/scene_reference.md": (SHAPES, code),
        "sample_scenes/closecall.schema.json": (SHAPES, literal),
    },
    "A mesh format": {
        "formats/scene/build/meshes.py": (SUFFIXES, lambda name: rf'"\.{name}"'),
        "tests/scene/test_mesh_fuzz.py": (SUFFIXES, spelt),
        "formats/scene/grammar/scene.py": (SUFFIXES, spelt),
        "README.md": (SUFFIXES, spelt),
    },
    "A bound": {
        "scheduler/model/events.py": (BOUNDS, literal),
        "formats/log/messages.proto": (BOUNDS, literal),
        "formats/report/sections.py": (BOUNDS, literal),
    },
    "A log topic": {
        "formats/log/messages.proto": (FACTS, lambda name: rf"Topic {name}\b"),
        "formats/log/writer.py": (FACTS, literal),
        "formats/log/container/checks.py": (TOPICS, literal),
        "formats/log/filters.py": (TOPICS, literal),
        "formats/log/tables/tables.py": (list(tables()), literal),
        "docs/tables.md": ([topic[1:] for topic in tables()], lambda name: rf"^## {name}$"),
        "tests/helpers/made_logs.py": (FACTS, literal),
        "README.md": (TOPICS, lambda name: rf"^\|.*`{name}`"),
    },
    "A command": {
        "cli/group.py": (list(COMMANDS), literal),
        "README.md": (list(COMMANDS), lambda name: rf"closecall {name}\b"),
    },
}
"""By the heading of each list: the places that hold all that there is, its names, and how they stand there."""


def section(heading: str) -> str:
    return TEXT.split(f"### {heading}\n", 1)[1].split("\n### ", 1)[0]


def test_each_place_that_is_named_exists() -> None:
    places = PLACE.findall(TEXT)
    assert len(places) > 60
    assert [place for place in places if not (ROOT / place).exists()] == []


@pytest.mark.parametrize("heading", HELD)
def test_a_list_names_every_place_that_holds_all_of_a_kind(heading: str) -> None:
    assert set(HELD[heading]) <= set(PLACE.findall(section(heading)))
    items = ITEM.split(section(heading))[1:]
    assert [int(item.split(".")[0]) for item in items] == list(range(1, len(items) + 1))


@pytest.mark.parametrize(("heading", "place"), [(heading, place) for heading in HELD for place in HELD[heading]])
def test_a_place_holds_all_that_there_is_of_a_kind(heading: str, place: str) -> None:
    names, form = HELD[heading][place]
    text = (ROOT / place).read_text(encoding="utf-8")
    assert len(names) >= 5
    missing = [name for name in names if not re.search(form(name), text, re.MULTILINE)]
    assert not missing, f"let {place} have them as well, see CONTRIBUTING.md"


def test_lists_are_those_of_the_headings() -> None:
    assert re.findall(r"^### (.+)$", TEXT, re.MULTILINE) == list(HELD)


def test_the_rooms_of_architecture_are_those_of_the_code() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for top in ("scheduler", "formats", "cli"):
        for path in (ROOT / top).rglob("__init__.py"):
            if "closecall" not in path.parts[len(ROOT.parts) :]:
                says = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").splitlines()[0]
                assert f"- `{path.parent.relative_to(ROOT).as_posix()}/`: {says}\n" in page
    for folder, floors in FLOORS.items():
        assert f"- `{folder}/`: {', '.join(floors)}\n" in page


def test_files_that_the_glossary_and_architecture_name_exist() -> None:
    for name in ("architecture.md", "glossary.md"):
        text = (ROOT / "docs" / name).read_text(encoding="utf-8")
        places = [
            place for place in PLACE.findall(text) if place.split("/")[0] in ("scheduler", "formats", "cli", "tests")
        ]
        assert len(places) > 20
        assert [place for place in places if not (ROOT / place).exists()] == []


def test_names_that_the_guarantees_cite_exist() -> None:
    """Classes with their members, functions and constants, as `Pair.depth`, `spendable` or `DISTANCE_ERROR`."""
    text = (ROOT / "docs" / "guarantees.md").read_text(encoding="utf-8")
    sources = [
        path.read_text(encoding="utf-8")
        for top in ("scheduler", "formats", "cli")
        for path in (ROOT / top).rglob("*.py")
    ]
    members = set(re.findall(r"`([A-Z]\w+)\.(\w+)`", text))
    assert len(members) > 15
    for name, member in members:
        homes = [source for source in sources if re.search(rf"^class {name}\b", source, re.MULTILINE)]
        assert any(re.search(rf"\b{member}\b", source) for source in homes), f"{name}.{member}"
    constants = set(re.findall(r"`(_?[A-Z][A-Z_]{4,})`", text))
    assert len(constants) > 15
    for name in constants - {"CONTACT", "BREACH", "CLEAR", "UNRESOLVED", "POSSIBLE", "START"}:
        assert any(re.search(rf"\b{name}\b", source) for source in sources), name


def test_each_topic_has_a_type() -> None:
    assert set(TYPES) == set(TOPICS)


def test_each_command_has_a_file_of_its_name() -> None:
    files = {path.stem for path in (ROOT / "cli" / "commands").glob("*.py")}
    assert files == {*COMMANDS, "__init__"}
