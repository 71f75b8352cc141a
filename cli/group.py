"""The `closecall` group; it imports the module of a subcommand when the user names that subcommand."""

from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from typing import Any

import click

from closecall import __version__

#: The shell sets this variable when it requests completions.
VARIABLE = "_CLOSECALL_COMPLETE"

COMMANDS = {
    "run": "Run a scene and write a certified log.",
    "check": "Validate a scene and print how it was read.",
    "summary": "Print the results in a log, worst pairs first.",
    "report": "Write an HTML report with a map, distance curves and a replay.",
    "diff": "Compare the results of a log with those of a golden log.",
    "export": "Convert the messages of a log to CSV, NDJSON or Parquet.",
    "extract": "Extract part of a log, or a file attached to it.",
    "completion": "Print the completion script for a shell.",
    "schema": "Print the JSON Schema of scene files.",
}


class LazyGroup(click.Group):
    """A group that imports the module of a command only when the command runs."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands' names."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the module of a command and return the command."""
        if cmd_name not in COMMANDS:
            return None
        command = import_module(f"closecall.cli.commands.{cmd_name}").command
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the words name; suggest a command for an unknown name."""
        from ..formats.scene.text.errors import quoted, suggestion

        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            ctx.fail(
                f"no such command {quoted(name)}{suggestion(name, COMMANDS)}; the commands are {', '.join(COMMANDS)}"
            )
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; exit quietly if the reader of its pipe has closed it, which click reports as a failure."""
        try:
            code = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            # discard the buffered output: writing it at exit would fail again
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(128 + signal.SIGPIPE)
        return code

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="closecall %(version)s")
def group() -> None:
    """Prove whether moving bodies come too close, and when.

    \b
    Examples:
      closecall run sample_scenes/spinning_bar/scene.yaml -o bar.mcap
      closecall summary bar.mcap
    """
