"""Several scenes: one table and the worst exit code. A failure does not stop the remaining scenes."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from ..formats.log.errors import LogError
from ..formats.log.severity import VERDICTS
from ..formats.scene.text.errors import SceneError
from .application.errors import OptionError, WorkerError
from .application.options import RunOptions
from .application.run import Result, run
from .faults import faults_reported, report
from .options import ConsoleOptions, misuse
from .progress import ProgressBar
from .show import STYLES, console_for, print_json, print_rows, print_warnings
from .terminal import cell, say


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of one scene: its log, its result (None if it failed) and its exit code."""

    scene: Path
    log: Path
    result: Result | None
    code: int


def run_many(scenes: Sequence[Path], folder: Path, options: RunOptions, console: ConsoleOptions) -> int:
    """Run every scene into a log of its own in `folder`; return the worst exit code."""
    logs = log_names(scenes)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"--out-dir {folder}: {error.strerror}.") from error
    outcomes = []
    for scene, name in zip(scenes, logs, strict=True):
        log = folder / name
        with faults_reported(log):
            outcomes.append(_run_one(scene, log, options, console))
    if console.as_json:
        print_json({"scenes": [_as_json(outcome) for outcome in outcomes]})
    elif not console.quiet:
        _print_table(outcomes)
    return max(outcome.code for outcome in outcomes)


def log_names(scenes: Sequence[Path]) -> list[str]:
    """Return the name of each scene's log: the name of the file, or of its folder if the file is called scene."""
    names = [f"{_folder_name(scene) if scene.stem == 'scene' else scene.stem}.mcap" for scene in scenes]
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise click.UsageError(f"Several scenes would write {', '.join(twice)}; run them separately.")
    return names


def _folder_name(scene: Path) -> str:
    return os.path.basename(os.path.dirname(os.path.realpath(scene)))  # realpath accepts broken links too


def _run_one(scene: Path, log: Path, options: RunOptions, console: ConsoleOptions) -> Outcome:
    """Run one scene; print its errors on stderr."""
    try:
        result = run(scene, log, options, watcher=ProgressBar(scene.name, console.quiet))
    except OptionError as error:  # another scene may allow the value
        say(f"{scene}: {misuse(error).format_message()}", to_stderr=True)
        return Outcome(scene, log, None, 2)
    except (SceneError, LogError, WorkerError) as fault:
        report(fault, log)
        return Outcome(scene, log, None, 2)
    if not console.quiet:
        print_warnings(result.warnings, result.note)
    return Outcome(scene, log, result, int(result.finds(console.fail_on)))


def _print_table(outcomes: Sequence[Outcome]) -> None:
    """Print one row per scene."""
    rows = []
    for outcome in outcomes:
        worst, found = "failed", "see the errors above"
        if outcome.result is not None:
            counts = outcome.result.summary["totals"]["pairs"]
            worst = next((verdict for verdict in VERDICTS if counts[verdict]), "no pairs")
            found = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
        log = "" if outcome.result is None else str(outcome.log)
        rows.append((cell(str(outcome.scene)), cell(worst, STYLES.get(worst, "bold red")), cell(found), cell(log)))
    print_rows(console_for(), ("scene", "worst", "pairs", "log"), rows)


def _as_json(outcome: Outcome) -> dict[str, object]:
    """Return the JSON value of one scene: its summary and seconds, or null if it failed."""
    told: dict[str, object] = {"scene": str(outcome.scene), "log": None, "exit": outcome.code, "summary": None}
    if outcome.result is not None:
        summary = {**outcome.result.summary, "seconds": outcome.result.seconds}
        told |= {"log": str(outcome.log), "summary": summary}
    return told
