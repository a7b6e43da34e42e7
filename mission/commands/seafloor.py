"""``--bathymetry FILE``: depths of the sea floor, for the check and the simulated sea."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mission.authoring.bathymetry import Depths


def depths_of(path: Path) -> Depths:
    """Read the depths. Exit 2 if the file cannot be read."""
    from mission.authoring.bathymetry import BathymetryError, read_bathymetry

    try:
        return read_bathymetry(path)
    except BathymetryError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
