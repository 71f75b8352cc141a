"""The errors of a run that concern neither its scene nor its log."""

from __future__ import annotations

from ...formats.scene.text.errors import printable


class OptionError(ValueError):
    """An option with a value that it cannot have. The text is one line.

    Attributes:
        option: its name in `RunOptions`.
        problem: what is wrong, and what is expected.
    """

    def __init__(self, option: str, problem: str) -> None:
        super().__init__(printable(f"{option}: {problem}"))
        self.option = option
        self.problem = problem


class WorkerError(Exception):
    """Workers that cannot be reached, or were lost. The text is one line: the problem and the remedy.

    Attributes:
        problem: what is wrong.
        remedy: what the caller can do about it.
    """

    def __init__(self, problem: str, remedy: str) -> None:
        super().__init__(f"{problem}; {remedy}")
        self.problem = problem
        self.remedy = remedy
