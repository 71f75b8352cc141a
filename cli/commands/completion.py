"""`closecall completion`: completion scripts for shells."""

from __future__ import annotations

import click

SHELLS = ("bash", "zsh", "fish")


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS))
def command(shell: str) -> int:
    """Print the script with which SHELL completes commands, options and file names.

    \b
    To install it for every new shell:
      bash  add to ~/.bashrc:  eval "$(closecall completion bash)"
      zsh   add to ~/.zshrc:   eval "$(closecall completion zsh)"
      fish  once:              closecall completion fish > ~/.config/fish/completions/closecall.fish

    \b
    Examples:
      eval "$(closecall completion bash)"
      closecall completion zsh > _closecall
    """
    from click.shell_completion import get_completion_class

    from ..group import VARIABLE, group

    kind = get_completion_class(shell)
    assert kind is not None
    click.echo(kind(group, {}, "closecall", VARIABLE).source())
    return 0
