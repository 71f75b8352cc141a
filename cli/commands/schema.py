"""`closecall schema`: the JSON Schema of scene files."""

from __future__ import annotations

import click


@click.command("schema")
def command() -> int:
    """Print the JSON Schema of scene files, for editors and generators.

    \b
    Examples:
      closecall schema > closecall.schema.json
    """
    from ...formats.scene.schema import schema_text

    click.echo(schema_text(), nl=False)
    return 0
