"""The `closecall` group; each subcommand is a module, imported when it is asked for."""

from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from typing import Any

import click

from closecall import __version__

#: Set by the shell's function when it asks for what may come next.
VARIABLE = "_CLOSECALL_COMPLETE"

COMMANDS = {
    "run": "Run a scene and write its certified log.",
    "check": "Check a scene and tell what was understood.",
    "summary": "Print what a log found, worst pairs first.",
    "report": "Write what a log found as one page with map, curves and replay.",
    "diff": "Compare a log with a golden one, by what they say.",
    "export": "Write a log's messages as tables: CSV, NDJSON, Parquet.",
    "extract": "Take a part of a log, or a file that travels with it.",
    "completion": "Print what makes a shell complete closecall's commands.",
    "schema": "Print the JSON Schema of the scene file.",
}


class LazyGroup(click.Group):
    """A group that imports a command's module only when the command is used."""

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
        """Return the command that the words name; of an unknown one say which it may have been."""
        from ..formats.scene.text.errors import quoted, suggestion

        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            ctx.fail(f"no such command {quoted(name)}{suggestion(name, COMMANDS)}; there are {', '.join(COMMANDS)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; end quietly where the reader of its pipe went away, which click would call a failure."""
        try:
            code = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            # what is still buffered goes nowhere, for it would fail again on the way out
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
    """Do any of these moving bodies come too close, and when? Answered with a certificate.

    \b
    Examples:
      closecall run sample_scenes/spinning_bar/scene.yaml -o bar.mcap
      closecall summary bar.mcap
    """
