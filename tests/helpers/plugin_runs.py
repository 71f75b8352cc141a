"""Runs of pytest with the plugin, in a project of their own."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

PLUGIN = "closecall.cli.pytest_plugin"


@dataclass(frozen=True)
class Ran:
    """How a run of pytest ended."""

    returncode: int
    stdout: str


def run_pytest(pytester: pytest.Pytester, *options: str) -> Ran:
    """Run pytest in the project's folder, with this plugin and no other."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
        result = pytester.runpytest_inprocess("-q", "-p", "no:cacheprovider", "-p", PLUGIN, *options, ".")
    return Ran(int(result.ret), str(result.stdout))
