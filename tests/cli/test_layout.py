"""The house: imports run one way, the wheel holds the package and nothing else, and starting is cheap."""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from floors import FLOORS
from places import ROOT

MAY_IMPORT = {
    "scheduler": {"scheduler"},
    "formats": {"scheduler", "formats"},
    "cli": {"scheduler", "formats", "cli"},
}
OTHER_TESTS = {"certificate", "helpers", "oracle", "spoilt", "studio"}
"""Folders of tests/ that are no room of the code: tests of whole runs, and what tests are made with."""

HEAVY_IN_SCHEDULER = {"trimesh", "mcap", "click", "pydantic", "yaml", "rich", "google"}


def sources(folder: str) -> list[Path]:
    return [path for path in (ROOT / folder).rglob("*.py") if "closecall" not in path.relative_to(ROOT).parts]


def imported(path: Path) -> set[str]:
    """Return the absolute dotted names that a module imports, relative ones resolved as inside `closecall`."""
    inside = ("closecall", *path.relative_to(ROOT).parts[:-1])
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = inside[: len(inside) - node.level + 1] if node.level else ()
            names.add(".".join((*base, *(node.module or "").split("."))).strip("."))
    return names


@pytest.mark.parametrize("folder", MAY_IMPORT)
def test_imports_run_one_way_from_cli_over_formats_to_scheduler(folder):
    assert sources(folder)
    for path in sources(folder):
        for name in imported(path):
            parts = name.split(".")
            if parts[0] == "closecall" and len(parts) > 1:
                assert parts[1] in MAY_IMPORT[folder], f"{path} imports {name}"


@pytest.mark.parametrize("folder", FLOORS)
def test_imports_run_down_the_floors_only(folder):
    floors = FLOORS[folder]
    standing = [path.relative_to(ROOT / folder).parts[0].removesuffix(".py") for path in sources(folder)]
    assert {*standing} == {*floors, "__init__"}
    prefix = ["closecall", *folder.split("/")]
    for path, here in zip(sources(folder), standing, strict=True):
        for name in imported(path):
            parts = name.split(".")
            if here != "__init__" and parts[: len(prefix)] == prefix and len(parts) > len(prefix):
                there = parts[len(prefix)]
                assert floors.index(there) <= floors.index(here), f"{path.relative_to(ROOT)} imports {name}"


def test_one_module_imports_fcl_and_the_scheduler_knows_no_file_format():
    assert [path.name for path in sources("scheduler") if "fcl" in imported(path)] == ["fcl_shape.py"]
    for path in sources("scheduler"):
        assert not {name.split(".")[0] for name in imported(path)} & HEAVY_IN_SCHEDULER
    for folder in ("formats", "cli"):
        assert not [path for path in sources(folder) if "fcl" in imported(path)]


def test_the_application_knows_no_command_line():
    for path in sources("cli/application"):
        assert not {name.split(".")[0] for name in imported(path)} & {"click", "rich", "pytest"}


def test_each_test_lies_in_the_room_of_the_code_that_it_tests():
    rooms = {path.parent.name for path in (ROOT / "scheduler").glob("*/__init__.py")}
    rooms |= {"cli", *(path.parent.name for path in (ROOT / "formats").glob("*/__init__.py"))}
    tests = [path.relative_to(ROOT / "tests").parts for path in (ROOT / "tests").rglob("test_*.py")]
    assert len(tests) > 100
    assert {len(parts) for parts in tests} == {2}, "tests/ROOM/test_FILE.py"
    assert {room for room, _ in tests} <= rooms | {"certificate"}
    folders = {path.name for path in (ROOT / "tests").iterdir() if path.is_dir()} - {"__pycache__"}
    assert folders <= rooms | OTHER_TESTS


def test_no_test_imports_from_another_test():
    for path in (ROOT / "tests").rglob("*.py"):
        tests = [name for name in imported(path) if name.split(".")[-1].startswith("test_")]
        assert not tests, f"{path} imports {tests}: let tests/helpers/ hold what they share"


def test_every_python_file_that_the_docs_name_is_there():
    """`test_cell.py` in docs/ci.md is the reader's own, FILE.py in docs/testing.md any file."""
    there = [f"/{path.relative_to(ROOT).as_posix()}" for path in ROOT.rglob("*.py")]
    named = {
        (page.name, name)
        for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
        for name in re.findall(r"`(?:[^`\n]* )?([\w./]+\.py)\b[^`\n]*`", page.read_text(encoding="utf-8"))
    }
    assert len(named) > 40
    gone = {one for one in named if not any(path.endswith(f"/{one[1]}") for path in there)}
    assert gone == {("ci.md", "test_cell.py"), ("testing.md", "FILE.py")}


def test_every_package_folder_is_listed_and_mapped():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    tops = {f"closecall.{folder}": folder for folder in MAY_IMPORT}
    assert setup["package-dir"] == {"closecall": "cli/closecall", **tops}
    folders = {path.parent.relative_to(ROOT) for folder in MAY_IMPORT for path in sources(folder)}
    assert set(setup["packages"]) == {"closecall"} | {"closecall." + ".".join(folder.parts) for folder in folders}


def test_the_wheel_holds_the_package_and_nothing_else(tmp_path):
    copy = tmp_path / "source"  # a build in place would take up what an earlier one left in build/
    for folder in MAY_IMPORT:
        shutil.copytree(ROOT / folder, copy / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    build = [sys.executable, "-m", "build", "--wheel", "--outdir", str(tmp_path), str(copy)]
    subprocess.run(build, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = [name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name]
    assert {name.split("/")[0] for name in names} == {"closecall"}
    held = {name for name in names if name.endswith(".py")}
    expected = {f"closecall/{path.relative_to(ROOT).as_posix()}" for folder in MAY_IMPORT for path in sources(folder)}
    assert held == expected | {f"closecall/{name}.py" for name in ("__init__", "__main__", "api")}
    assert "closecall/py.typed" in names
    assert "closecall/formats/log/messages.proto" in names
    parts = {f"closecall/formats/report/page/{path.name}" for path in (ROOT / "formats/report/page").iterdir()}
    assert len(parts) > 10
    assert parts <= set(names)


@pytest.mark.parametrize("arguments", [["--version"], ["--help"]])
def test_asking_for_version_or_help_imports_nothing_heavy(arguments):
    code = (
        "import sys; sys.argv = ['closecall', *sys.argv[1:]]\n"
        "from closecall.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: print(*sorted(sys.modules), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    loaded = {name.split(".")[0] for name in done.stderr.split()}
    assert not loaded & {"numpy", "trimesh", "fcl", "mcap", "pydantic", "rich", "google"}
