"""``auvmission schema``: print the JSON Schema of missions in YAML, for editors."""

from __future__ import annotations

import click


@click.command()
def schema() -> None:
    """Print the JSON Schema of missions in YAML.

    Save it, and begin a mission with
    "# yaml-language-server: $schema=mission.schema.json" for completion and hover in VS Code.
    """
    from mission.authoring.language.schema import schema_text

    click.echo(schema_text(), nl=False)
