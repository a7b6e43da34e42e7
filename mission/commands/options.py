"""Options that several commands share, so that they are called and explained alike."""

from __future__ import annotations

import click

PARAMETERS = click.option(
    "--param",
    "parameters",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a parameter of the mission; repeatable.",
)
VEHICLE = click.option(
    "--vehicle",
    metavar="FILE|NAME",
    help="Vehicle file, or a shipped vehicle's name; default: the vehicle the mission names.",
)
LOGGED_VEHICLE = click.option(
    "--vehicle",
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
AS_JSON = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object on standard output."
)
