"""A pytest plugin: scenes are run, and their logs compared with golden ones that lie beside the tests.

It is loaded by pytest itself wherever closecall is installed, so it imports the rest when a test asks for it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from ..formats.log.diff.findings import Rules

_UPDATE = "--closecall-update"

# Goldens are small: what viewers get, and the meshes, are left out.
_GOLDEN_OPTIONS = ("--log", "certificate", "--no-attach-meshes")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that writes goldens."""
    group = parser.getgroup("closecall", "golden logs of closecall")
    group.addoption(
        _UPDATE, action="store_true", help="Write the golden logs that are missing, or that differ, instead of failing."
    )


@pytest.fixture
def closecall_golden(request: pytest.FixtureRequest, tmp_path: Path) -> Golden:
    """Run scenes and compare their logs with the golden ones beside the test, `<test file>/<test>.mcap`."""
    test = request.node.nodeid.partition("::")[2].replace("::", "-")
    return Golden(request.path, test, tmp_path, bool(request.config.getoption(_UPDATE)))


class Golden:
    """The golden logs of one test.

    Args:
        test_file: the test's file: scenes are relative to its folder, goldens lie in a folder of its name.
        test: the test's name, with those of its classes and its parameters.
        scratch: where new logs go.
        update: whether to write goldens instead of failing.
    """

    def __init__(self, test_file: Path, test: str, scratch: Path, update: bool) -> None:
        self._test_file = test_file
        self._test = re.sub(r"[^\w.-]+", "_", test).strip("_")
        self._scratch = scratch
        self._update = update

    def check(
        self,
        scene: str | Path,
        *options: str,
        name: str = "",
        time_tol: float = 1e-6,
        time_rtol: float = 0.0,
        distance_tol: float = 1e-6,
        distance_rtol: float = 0.0,
        within_brackets: bool = False,
        ignore: Sequence[str] = (),
    ) -> None:
        """Run a scene and fail the test where its log says something else than the golden one.

        Args:
            scene: the scene file, relative to the test's folder.
            options: of the run, as words on the command line of `closecall run`.
            name: tells several goldens of one test apart.
            time_tol, time_rtol, distance_tol, distance_rtol, within_brackets, ignore: as those of `closecall diff`.
        """
        __tracebackhide__ = True
        from ..formats.log.diff.difference import Ignored, Tolerances
        from ..formats.log.diff.findings import Rules

        rules = Rules(
            Tolerances(time_tol, distance_tol, time_rtol, distance_rtol), Ignored(tuple(ignore)), within_brackets
        )
        file = "-".join(part for part in (self._test, name) if part) + ".mcap"
        new = self._run(self._test_file.parent / scene, self._scratch / file, options)
        golden = self._test_file.with_suffix("") / file
        problem = self._problem(golden, new, rules)
        if problem and self._update:
            golden.parent.mkdir(exist_ok=True)
            golden.write_bytes(new.read_bytes())
        elif problem:
            pytest.fail(f"{problem}\nnew log: {new}\nto accept it: pytest {_UPDATE}", pytrace=False)

    def _run(self, scene: Path, log: Path, options: Sequence[str]) -> Path:
        __tracebackhide__ = True
        import click

        from ..formats.log.errors import LogError
        from ..formats.scene.text.errors import SceneError
        from .application.errors import OptionError, WorkerError
        from .application.run import run
        from .options import options_of

        try:
            run(scene, log, options_of([*_GOLDEN_OPTIONS, *options]))
        except click.ClickException as fault:
            pytest.fail(fault.format_message(), pytrace=False)
        except (OptionError, SceneError, LogError, WorkerError) as fault:
            pytest.fail(str(fault), pytrace=False)
        return log

    def _problem(self, golden: Path, new: Path, rules: Rules) -> str:
        """Return what is wrong with the new log, by the golden one; nothing where it says the same."""
        from ..formats.log.diff.compare import compare
        from ..formats.log.diff.wording import sentence
        from ..formats.log.errors import LogError

        if not golden.exists():
            return f"the golden log {golden} does not exist"
        try:
            found = compare(golden, new, rules)
        except LogError as fault:
            return str(fault)
        lines = [str(loss) for loss in found.losses] + [sentence(one, found.length_unit) for one in found.largest(10)]
        more = len(found.differences) - 10
        lines += [f"... and {more} more: closecall diff {golden} {new}"] * (more > 0)
        return "\n".join(lines)
