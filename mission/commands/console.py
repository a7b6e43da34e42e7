"""``auvmission console``: the cockpit, a page in this computer's browser."""

from __future__ import annotations

import asyncio
import os
import random
import re
import socket
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click

from mission.commands.demo import clear_earlier
from mission.commands.monitor import beside
from mission.commands.options import MISSION, SEED, SETTINGS, VEHICLE

if TYPE_CHECKING:
    from mission.authoring.prepare import Prepared
    from mission.console.app import Shown
    from mission.console.charts.shelf import Shelf
    from mission.console.recording import Recording
    from mission.console.vehicle import Given

USUAL = "tcp://127.0.0.1:4000"
_NAMED = re.compile(r"(?:(?P<name>[\w.-]+)=)?(?P<url>[a-z][a-z+.-]*://.+)")


@click.command()
@click.argument("recordings", nargs=-1, metavar="[LOG.mcap]...")
@click.option("--to", "urls", multiple=True, metavar="[NAME=]URL",
              help=f"Where a vehicle's Pi listens; repeatable.  [default: {USUAL}]")  # fmt: skip
@click.option("--monitor", "monitors", multiple=True, metavar="URL",
              help="Of each vehicle, in order; none.  [default: at the port after]")  # fmt: skip
@click.option("--simulate", type=MISSION, metavar="MISSION",
              help="Begin a simulated vehicle and its serve, and start MISSION.")  # fmt: skip
@click.option("--speed", type=click.FloatRange(0.1, 20.0), default=1.0, show_default=True,
              help="Of what is simulated, times real time.")  # fmt: skip
@SEED
@SETTINGS
@VEHICLE
@click.option("--checklist", type=click.Path(path_type=Path, dir_okay=False, exists=True),
              help="A text file, a manual point a line, to be ticked before a start.")  # fmt: skip
@click.option("--chart", "charts", multiple=True, type=click.Path(path_type=Path), metavar="FILE",
              help="Under the vehicle: GeoJSON, MBTiles, PMTiles, a picture with its corners, a "
                   "grid of depths (.asc) or soundings (.xyz, .csv); repeatable.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0,
              help="Of the page, on this computer alone.  [default: any free one]")  # fmt: skip
@click.option("--browser/--no-browser", default=True, help="Open the page.  [default: yes]")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False),
              default=Path("out/console"), show_default=True,
              help="For what --simulate leaves; an earlier one's is removed.")  # fmt: skip
def console(
    recordings: tuple[str, ...],
    urls: tuple[str, ...],
    monitors: tuple[str, ...],
    simulate: Path | None,
    speed: float,
    seed: int,
    settings: tuple[str, ...],
    vehicle: str | None,
    checklist: Path | None,
    charts: tuple[Path, ...],
    port: int,
    browser: bool,
    out: Path,
) -> None:
    """Plan, fly, steer and review in a browser: chart, states, margins, journal, X and W, stick.

    The page reviews LOG.mcap; a mission's name in its place is simulated and reviewed. Only this
    computer can reach the page. Its address contains the token that opens it.

    Ctrl-C ends it. Exit 1 if a simulated vehicle does not start, 2 if an argument is wrong.
    """
    try:
        from mission.console.serving import listen
    except ImportError as error:
        _end(f"console needs its extra: pip install 'auvmission[console]' ({error})")
    points, shelf = _points(checklist), _shelf(charts)
    given = [] if recordings and not urls else _given(urls, monitors, vehicle, points)
    replayed = [(name, _recording(name, seed, settings)) for name in recordings]
    try:
        listening = listen(port)
    except OSError as error:
        _end(f"port {port} of this computer: {error.strerror}: give another --port")
    with listening:
        if simulate is None:
            _run(listening, given, replayed, shelf, vehicle, browser)
            return
        prepared = _prepared(simulate, vehicle, settings)
        with _simulated(prepared, vehicle, out, (speed, seed, settings), points) as simulated:
            more = [] if not urls else given
            _run(listening, [simulated, *more], replayed, shelf, vehicle, browser)


def _run(
    listening: socket.socket,
    given: Sequence[Given],
    replayed: Sequence[tuple[str, Recording]],
    shelf: Shelf,
    vehicle: str | None,
    browser: bool,
) -> None:
    from mission.console.recorded import Recorded, told_apart
    from mission.console.serving import serve
    from mission.console.vehicle import Vehicle
    from mission.topside.dives import default_folder

    def made() -> list[Shown]:
        live = [Vehicle(str(n), one, default_folder()) for n, one in enumerate(given, 1)]
        names = told_apart([file for file, _ in replayed])
        shown = enumerate(zip(names, replayed, strict=True), len(live) + 1)
        return [*live, *(Recorded(str(n), name, r, vehicle) for n, (name, (_, r)) in shown)]

    def ready(address: str) -> None:
        click.echo(f"open {address}")
        if browser:
            _open(address)

    asyncio.run(serve(listening, made, ready, charts=shelf))


def _open(address: str) -> None:
    """Open a browser window. No text browser: it would take over this terminal."""
    import webbrowser

    windows = sys.platform in ("darwin", "win32")
    if windows or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        with suppress(webbrowser.Error):
            webbrowser.open(address)


def _end(why: str, code: int = 2) -> NoReturn:
    click.echo(why, err=True)
    raise SystemExit(code)


# --- what is shown -------------------------------------------------------------------------------


def _points(checklist: Path | None) -> tuple[str, ...]:
    if checklist is None:
        return ()
    lines = checklist.read_text(encoding="utf-8", errors="replace").splitlines()[:100]
    return tuple(line.strip()[:200] for line in lines if line.strip())


def _shelf(charts: tuple[Path, ...]) -> Shelf:
    from mission.console.charts.layer import ChartError
    from mission.console.charts.shelf import Shelf
    from mission.console.charts.world import read_world
    from mission.topside.dives import default_folder

    try:
        return Shelf(default_folder(), charts, read_world())
    except ChartError as error:
        _end(f"--chart {error}")


def _given(
    urls: tuple[str, ...], monitors: tuple[str, ...], vehicle: str | None, points: tuple[str, ...]
) -> list[Given]:
    from mission.console.vehicle import Given

    if len(monitors) > max(1, len(urls)):
        raise click.UsageError(f"{len(monitors)} monitors for {max(1, len(urls))} vehicles")
    found = []
    for number, text in enumerate(urls or (USUAL,)):
        named = _NAMED.fullmatch(text)
        if named is None:
            raise click.UsageError(f"--to {text}: write e.g. tcp://vehicle:4000, or NAME=URL")
        name, url = named["name"], named["url"]
        own = monitors[number] if number < len(monitors) else _monitor_of(url)
        found.append(Given(name or _host(url), url, _wanted(own), vehicle, checklist=points))
    return found


def _wanted(monitor: str) -> str:
    return "" if monitor == "none" else monitor


def _host(url: str) -> str:
    return url.partition("://")[2].partition("?")[0]


def _monitor_of(url: str) -> str:
    """The URL of the port after the operator's; "" if there cannot be a monitor."""
    from links.base import LinkError
    from mission.topside.underwater import modem_address
    from mission.topside.upload import OperatorError

    try:
        return "" if modem_address(url) is not None else beside(url, 1)
    except (OperatorError, LinkError) as error:
        raise click.UsageError(str(error)) from None


def _recording(name: str, seed: int, settings: tuple[str, ...]) -> Recording:
    from mission.commands.watch import recorded
    from mission.console.recording import Recording
    from mission.onboard.blackbox import BlackBoxError

    try:
        return Recording(recorded(name, seed, settings))
    except (ValueError, OSError, BlackBoxError) as error:
        _end(f"{name}: {error}")


# --- what is simulated ---------------------------------------------------------------------------


def _prepared(mission: Path, vehicle: str | None, settings: tuple[str, ...]) -> Prepared:
    from links.simulated.settings import SettingError, parse_settings
    from mission.authoring.prepare import Unreadable, check_prepared, prepare

    try:
        prepared = prepare(mission, vehicle)
        parse_settings(settings)
    except (Unreadable, SettingError) as error:
        _end(str(error))
    if not check_prepared(prepared).ok:
        _end(f"{mission}: refused by the check; see auvmission check {mission}", 1)
    return prepared


@contextmanager
def _simulated(
    prepared: Prepared,
    vehicle: str | None,
    out: Path,
    how: tuple[float, int, tuple[str, ...]],
    points: tuple[str, ...],
) -> Iterator[Given]:
    """Run a simulated vehicle and its serve, with the mission under way."""
    from mission.console.vehicle import Given
    from mission.topside.upload import OperatorError
    from mission.verification.simulation.demo import LEFT
    from mission.verification.simulation.staged import READY_S, DemoError, Stage, told_to_end

    clear_earlier(out, LEFT)
    out.mkdir(parents=True, exist_ok=True)
    speed, seed, settings = how
    named = vehicle or prepared.mission.vehicle
    stage = Stage(prepared, out, named, speed, seed, settings, _two_free_ports())
    try:
        with told_to_end(), stage.vehicle() as made, stage.serve(made) as events:
            to = events.take(READY_S)["topside"]
            events.ignore()
            _begin(to, prepared, click.echo)
            name = f"simulated {Path(named).stem}"
            yield Given(name, to, _monitor_of(to), vehicle, speed, points, simulated=True)
    except (DemoError, OperatorError) as error:
        _end(str(error), 1)


def _begin(to: str, prepared: Prepared, tell: Callable[[str], None]) -> None:
    """Upload the mission and start it. Raises OperatorError."""
    from mission.authoring.language import script
    from mission.topside.console import converse
    from mission.topside.upload import start, upload

    lines = script(prepared.mission)
    tell(converse(to, upload(lines, prepared.chart.digest, lambda have, total: None)))
    tell(converse(to, start(patience=30)))


def _two_free_ports() -> int:
    """The first of two consecutive free ports. They are free again when this returns.

    They are below the range of client ports, so that no client takes them meanwhile."""
    host = "127.0.0.1"
    while True:
        port = random.SystemRandom().randrange(10_000, 32_000)
        with suppress(OSError), socket.create_server((host, port)):  # noqa: SIM117
            with socket.create_server((host, port + 1)):
                return port
