"""The value of `--fail-on`."""

from __future__ import annotations

import click

#: Verdicts that a run may be told to fail on.
FINDINGS = ("contact", "breach", "unresolved", "possible")


def parse_findings(ctx: click.Context, param: click.Parameter, value: str | None) -> tuple[str, ...]:
    """Split a comma-separated choice of verdicts and check each."""
    chosen = tuple(part.strip() for part in value.split(",")) if value is not None else ()
    for part in chosen:
        if part not in FINDINGS:
            raise click.BadParameter(f"{part!r} is not one of {', '.join(FINDINGS)}.", ctx, param)
    return chosen
