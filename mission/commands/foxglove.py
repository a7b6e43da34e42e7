"""``auvmission foxglove``: show a vehicle under way or a black box in Foxglove or Lichtblick."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mission.commands.monitor import MONITOR
from mission.commands.options import LinkUrlOrFile
from mission.commands.output import write

if TYPE_CHECKING:
    from mission.analysis.foxglove.serving import Server

LISTEN = "127.0.0.1:8765"


@click.command()
@click.option("--to", type=LinkUrlOrFile(), default=MONITOR, show_default=True, metavar="URL|FILE",
              help="A vehicle's monitor, or a black box.")  # fmt: skip
@click.option("--listen", default=LISTEN, show_default=True, metavar="HOST:PORT",
              help="Where viewers connect; port 0: any that is free.")  # fmt: skip
@click.option("--speed", type=click.FloatRange(0.01, 1000.0), default=1.0, show_default=True,
              help="Times real time, of a black box.")  # fmt: skip
@click.option("--layout", type=click.Path(path_type=Path, dir_okay=False),
              help="Write the layout to this file, for viewers to import, and end.")  # fmt: skip
@click.option("--for", "seconds", default=0.0, metavar="SECONDS", help="End after so long.")
def foxglove(to: str, listen: str, speed: float, layout: Path | None, seconds: float) -> None:
    """Serve the stream to Foxglove and Lichtblick, by their WebSocket protocol.

    Connect to ws://HOST:PORT there, and import the layout. A black box is played once from its
    beginning; its end stays shown. Viewers cannot command the vehicle.

    Exit 0 when the time is over, 1 if the monitor is missing or the port cannot be used, 2 if FILE
    is no black box.
    """
    if layout is not None:
        _write_layout(layout)
        return
    from links.base import LinkError
    from mission.onboard.blackbox import BlackBoxError
    from mission.topside.monitor import NoMonitor

    host, port = _address(listen)
    end = time.monotonic() + seconds if seconds else float("inf")
    try:
        ticks = _live(to, host, port) if "://" in to else _played(Path(to), host, port, speed)
        for _ in ticks:
            if time.monotonic() >= end:
                return
    except ImportError as error:
        needs = "foxglove needs its library: pip install 'auvmission[foxglove]'"
        raise _failed(f"{needs} ({error})", 2) from None
    except BlackBoxError as error:
        raise _failed(str(error), 2) from None
    except (LinkError, NoMonitor, OSError, RuntimeError) as error:
        raise _failed(str(error), 1) from None


def _write_layout(path: Path) -> None:
    from mission.analysis.foxglove.layout import layout

    write(path, json.dumps(layout(), indent=2) + "\n")


def _live(url: str, host: str, port: int) -> Iterator[None]:
    """Serve what the monitor sends. Yields between frames, without end."""
    from mission.analysis.foxglove.live import TOPICS, Live
    from mission.topside.console import observe
    from mission.topside.monitor import Watched, wish

    watched, live, server = Watched(), Live(), None
    try:
        for frame in observe(url, wish(track=False), watched):
            if server is None and frame is not None:  # there is a monitor
                server = _server(host, port, TOPICS)
            if server is not None and frame is not None:
                wall = time.time()
                for message in live.receive(watched, frame, wall):
                    server.send(message, wall)
            yield
    finally:
        if server is not None:
            server.close()


def _played(path: Path, host: str, port: int, speed: float) -> Iterator[None]:
    """Serve a recording at its speed. Yields while it waits, without end. Raises BlackBoxError."""
    from mission.analysis.foxglove.playing import TOPICS, begun, messages
    from mission.analysis.journal import recordings

    (items,) = recordings([path])
    wall, server = begun(items), _server(host, port, TOPICS)
    try:
        zero = time.monotonic()
        for message in messages(items):
            while (now := (time.monotonic() - zero) * speed) < message.t:
                server.time(wall + now)
                time.sleep(min(0.05, (message.t - now) / speed))
                yield
            server.send(message, wall + message.t)
        while True:
            time.sleep(0.05)
            yield
    finally:
        server.close()


def _address(listen: str) -> tuple[str, int]:
    """Host and port. Raises BadParameter."""
    host, _, port = listen.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise click.BadParameter(f"{listen!r} is no HOST:PORT, as {LISTEN}", param_hint="--listen")
    return host, int(port)


def _server(host: str, port: int, names: tuple[str, ...]) -> Server:
    from mission.analysis.foxglove.serving import Server

    try:
        server = Server(host, port, names)
    except (OSError, RuntimeError) as error:
        raise OSError(f"--listen {host}:{port}: {error}") from None
    click.echo(f"viewers connect to ws://{host}:{server.port}")
    return server


def _failed(why: str, code: int) -> SystemExit:
    click.echo(why, err=True)
    return SystemExit(code)
