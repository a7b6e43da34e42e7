"""``auvmission watch``: show a live, recorded or simulated dive, full screen."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.monitor import MONITOR, beside
from mission.commands.options import SEED, SETTINGS, LinkUrl, LinkUrlOrFile

if TYPE_CHECKING:
    from mission.model import Record
    from mission.topside.sources import Source


@click.command()
@click.argument("source", type=LinkUrlOrFile(), default=MONITOR)
@click.option("--to", type=LinkUrl(), metavar="URL",
              help="Where the vehicle's Pi listens; default: at SOURCE, the port before the "
              "monitor's.")  # fmt: skip
@click.option("--frames", is_flag=True, help="Ask the port of --to, where there is no monitor.")
@click.option("--speed", default=1.0, show_default=True, help="Of a dive of before, or simulated.")
@SEED
@SETTINGS
def watch(
    source: str, to: str | None, frames: bool, speed: float, seed: int, settings: tuple[str, ...]
) -> None:
    """Watch a vehicle on one screen: alarms, state, leg, place, margins, journal.

    SOURCE is a monitor's URL, a black box (played at --speed), or a mission, which is simulated. X
    and W need one key press, start and clear two. Commands are sent to --to.

    Exit 0 if you ended it, 2 if SOURCE is none of these.
    """
    try:
        from mission.topside.dives import default_folder
        from mission.topside.watch import WatchApp
    except ImportError as error:
        click.echo(f"watch needs Textual: pip install 'auvmission[watch]' ({error})", err=True)
        raise SystemExit(2) from None
    to = to or beside(source if "://" in source else MONITOR, -1)
    found = _frames(to) if frames else _source(source, speed, seed, settings)
    WatchApp(found, to if found.live else "", default_folder()).run()


def _frames(to: str) -> Source:
    from mission.topside.sources import from_frames

    return from_frames(to)


def _source(text: str, speed: float, seed: int, settings: tuple[str, ...]) -> Source:
    from mission.analysis.replay.playback import Playback
    from mission.onboard.blackbox import BlackBoxError
    from mission.topside.sources import from_monitor, from_recording

    if "://" in text:
        return from_monitor(text)
    try:
        return from_recording(Playback(recorded(text, seed, settings)), speed)
    except (ValueError, OSError, BlackBoxError) as error:
        click.echo(f"{text}: {error}", err=True)
        raise SystemExit(2) from None


def recorded(text: str, seed: int = 0, settings: tuple[str, ...] = ()) -> list[Record]:
    """Records of a black box or a simulated mission. Raises ValueError, OSError, BlackBoxError."""
    if Path(text).suffix != ".mcap":
        return _simulated(text, seed, settings)
    from mission.onboard.blackbox import read_parts

    return list(read_parts(Path(text)))


def _simulated(name: str, seed: int, settings: tuple[str, ...]) -> list[Record]:
    from links.simulated.settings import parse_settings
    from mission.authoring.prepare import prepare
    from mission.onboard.runtime.records import ListRecorder
    from mission.verification.simulation.flight import fly

    prepared, recorder = prepare(Path(name)), ListRecorder()
    fly(prepared.mission, prepared.vehicle, "", seed, parse_settings(settings), recorder)
    return recorder.records
