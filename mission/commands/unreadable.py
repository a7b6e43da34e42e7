"""Print the errors of a mission: on stderr for people, and with ``--json`` on stdout as data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mission.model.diagnostics import Diagnosed


def tell_unreadable(error: Diagnosed, as_json: bool) -> None:
    """Print the errors. The object is that of ``check --json``: place, code and hint of each."""
    import json

    from mission.authoring.check.show import unreadable_object

    click.echo(str(error), err=True)
    if as_json:
        click.echo(json.dumps(unreadable_object(error.diagnostics)))
