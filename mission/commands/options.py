"""Options that several commands share, with the same name and help everywhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem


class ShippedOrFile(click.Path):
    """A path, which the shell also completes with the names of shipped files, and with files of
    this folder that have one of the suffixes. If none fits, the shell completes files as usual."""

    def __init__(
        self, names: Callable[[], Iterable[str]], suffixes: Iterable[str], **how: Any
    ) -> None:
        super().__init__(**how)
        self._names, self._suffixes = names, tuple(suffixes)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        here = (path.name for path in Path().iterdir() if path.suffix in self._suffixes)
        fits = [name for name in (*self._names(), *sorted(here)) if name.startswith(incomplete)]
        return [*map(CompletionItem, fits)] or super().shell_complete(ctx, param, incomplete)


class LinkUrl(click.ParamType):  # type: ignore[type-arg]  # generic since click 8.3
    """A link's URL. A wrong one is a usage error (exit 2), found before the link is tried."""

    name = "url"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from links import LinkAddressError, check_url
        from mission.topside.underwater import modem_address
        from mission.topside.upload import OperatorError

        try:
            modem = modem_address(value)
            check_url(value if modem is None else modem.link)
        except (LinkAddressError, OperatorError) as error:
            self.fail(str(error), param, ctx)
        return str(value)


class LinkUrlOrFile(LinkUrl):
    """A link's URL, or a file or name, which contains no ``://``."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return super().convert(value, param, ctx) if "://" in value else str(value)


def _missions() -> Iterable[str]:
    from mission.model.shipped import shipped_missions

    return shipped_missions()


def _vehicles() -> Iterable[str]:
    from mission.model.shipped import shipped_vehicles

    return shipped_vehicles()


MISSION = ShippedOrFile(_missions, (".yaml", ".yml", ".mission"), path_type=Path)
VEHICLE_NAME = ShippedOrFile(_vehicles, (".yaml", ".yml"))

PARAMETERS = click.option(
    "--param",
    "parameters",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a parameter of the mission; repeatable.",
)
VEHICLE = click.option(
    "--vehicle",
    type=VEHICLE_NAME,
    metavar="FILE|NAME",
    help="Vehicle file, or a shipped vehicle's name; default: the vehicle the mission names.",
)
LOGGED_VEHICLE = click.option(
    "--vehicle",
    type=VEHICLE_NAME,
    metavar="FILE|NAME",
    help="Vehicle file, or a shipped vehicle's name; default: the vehicle in the black box.",
)
PROFILE = click.option(
    "--profile",
    type=click.Choice(["as-built", "documented"]),
    help="Simulate the AUV as it was built, or as its document describes it; default: the dialect "
    "of the vehicle file.",
)
SEED = click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Seed of everything that is random.",
)
SETTINGS = click.option(
    "--set",
    "settings",
    metavar="KEY=VALUE",
    multiple=True,
    help="Sea and faults, e.g. current=0.3@45 (m/s towards deg) or "
    "fault=depth_frozen@120+60 (from 120 s, for 60 s); repeatable.",
)
BATHYMETRY = click.option(
    "--bathymetry",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Depths of the sea floor: ESRI ASCII grid, GeoJSON, or a table of soundings.",
)
AS_JSON = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object on standard output."
)


def tell_confirmed(vehicle: str) -> None:
    """Print, on stderr, that a campaign flies with other signs than the shipped file has."""
    from mission.verification.rig.vehicle import CONFIRMED

    if vehicle in CONFIRMED:
        said = f"flown as if its file said outer_loop: {{confirmed: {CONFIRMED[vehicle]}}}"
        click.echo(f"{vehicle}: {said}; as shipped it holds nothing (R17)", err=True)
