"""Runs whose logs the oracle checks: how they are made, how hard they are tried, and a fault put into a log."""

from __future__ import annotations

import sys
from pathlib import Path
from unittest.mock import patch

import pytest

from closecall.cli.main import main
from oracle.logs import Log

QUICK = {"uniform": 160, "scattered": 40, "minima": 3, "messages": 24}
DEEP = {"uniform": 2000, "scattered": 500, "minima": 20, "messages": 200}
"""How many instants of a log the plain suite tries, and deep tests."""

EPOCH = 2_000_000_000
"""ns: scenes may begin a second before 0, which logs cannot."""


def logged(scene: Path, *options: str) -> Path:
    """Run the tool on a scene file and return the log."""
    log = scene.with_suffix(".mcap")
    arguments = ["closecall", "run", str(scene), "-o", str(log), "--quiet", "--epoch", str(EPOCH), *options]
    with patch.object(sys, "argv", arguments):
        with pytest.raises(SystemExit) as ended:
            main()
        assert not ended.value.code, f"{scene.name}: exit {ended.value.code}"
    return log


def clear_the_contact(log: Log) -> None:
    for span in log.of("spans"):
        if span["verdict"] == "CONTACT":
            span["verdict"] = "CLEAR"
