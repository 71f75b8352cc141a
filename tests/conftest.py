"""What every test starts from."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from tempfile import mkdtemp

import pytest

SAMPLE_RUNS = "CLOSECALL_SAMPLE_RUNS"
"""Names the folder where the runs of the samples are kept, which all test processes share."""

SLOW = {
    "certificate": {"*"},
    "bounds": {"*"},
    "broad": {"*"},
    "cli": {"*"},
    "log": {"*"},
    "motions": {
        "test_unknown_path.py",
        "test_small_numbers.py",
        "test_acceleration_set.py",
        "test_many_keys.py",
        "test_rounding.py",
        "test_motions.py",
        "test_untried.py",
    },
    "narrow": {"*"},
    "pairs": {
        "test_coarse_times.py",
        "test_brackets.py",
        "test_extremes.py",
        "test_least_distance.py",
        "test_run.py",
        "test_large_errors.py",
    },
    "parallel": {"*"},
    "report": {"*"},
    "scene": {"test_fuzz.py", "test_mesh_fuzz.py", "test_untried.py", "test_turns.py", "test_mesh_glb.py"},
    "snapshots": {"*"},
    "solids": {"*"},
}
"""By room, the files that are no part of `pytest -m quick`."""


def is_quick(path: Path) -> bool:
    slow = SLOW.get(path.parent.name, set())
    return "*" not in slow and path.name not in slow


def pytest_collection_modifyitems(items: Sequence[pytest.Item]) -> None:
    """Mark what is quick."""
    for item in items:
        if is_quick(item.path):
            item.add_marker(pytest.mark.quick)


def pytest_configure(config: pytest.Config) -> None:
    """Forget the width of the terminal, for outputs go down a pipe, and make the shared folder."""
    os.environ.pop("COLUMNS", None)
    if not hasattr(config, "workerinput"):
        os.environ[SAMPLE_RUNS] = mkdtemp(prefix="closecall-samples-")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Remove the shared folder."""
    if not hasattr(config, "workerinput"):
        shutil.rmtree(os.environ.pop(SAMPLE_RUNS), ignore_errors=True)
