"""What every test starts from."""

from __future__ import annotations

import os
import shutil
from tempfile import mkdtemp

import pytest

SAMPLE_RUNS = "CLOSECALL_SAMPLE_RUNS"
"""Names the folder where the runs of the samples are kept, which all test processes share."""


def pytest_configure(config: pytest.Config) -> None:
    """Forget the width of the terminal, for outputs go down a pipe, and make the shared folder."""
    os.environ.pop("COLUMNS", None)
    if not hasattr(config, "workerinput"):
        os.environ[SAMPLE_RUNS] = mkdtemp(prefix="closecall-samples-")


def pytest_unconfigure(config: pytest.Config) -> None:
    """Remove the shared folder."""
    if not hasattr(config, "workerinput"):
        shutil.rmtree(os.environ.pop(SAMPLE_RUNS), ignore_errors=True)
