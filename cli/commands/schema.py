"""`closecall schema`: the JSON Schema of the scene file."""

from __future__ import annotations

import click


@click.command("schema")
def command() -> int:
    """Print the JSON Schema of the scene file, for editors and generators.

    \b
    Examples:
      closecall schema > closecall.schema.json
    """
    from ...formats.scene.schema import schema_text

    click.echo(schema_text(), nl=False)
    return 0
