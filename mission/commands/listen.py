"""``auvmission listen``: show a link live, one line per frame."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import click

from mission.commands.options import LinkUrl

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from links.base import Rx
    from mission.onboard.doctor.holder import Holder
    from mission.topside.hearing import Heard

# Links on which serve sends, seen from its side; and those that cover both directions.
_SAID = (
    "auv.to_stm32", "auv.to_topside", "coreboard.pc_to_main", "coreboard.main_to_sensor",
    "rov.down", "robot.down",
)  # fmt: skip
_BUS = "coreboard.can"
_BOTH = ("auv.any", "auv.modem", _BUS)


@click.command()
@click.argument("url", type=LinkUrl(), metavar="URL")
@click.option("--link", "link_name", required=True, metavar="NAME",
              help="What is on it, e.g. auv.from_stm32; docs/protocol.md lists all.")  # fmt: skip
@click.option("--raw", is_flag=True, help="The bytes of each frame and fault, in hexadecimal.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object per line.")
@click.option("--record", type=click.Path(path_type=Path, dir_okay=False),
              help="Keep the bytes in this new file; auvmission decode reads it.")  # fmt: skip
@click.option("--for", "seconds", type=click.FloatRange(min=0.1), metavar="SECONDS",
              help="End after so long; else Ctrl-C ends it.")  # fmt: skip
@click.option("--option", "options", multiple=True, metavar="K=V", help="A tolerance, by name.")
@click.option("-c", "--config", type=click.Path(path_type=Path),
              help="As for serve: whose ports may be taken.")  # fmt: skip
def listen(
    url: str,
    link_name: str,
    raw: bool,
    as_json: bool,
    record: Path | None,
    seconds: float | None,
    options: tuple[str, ...],
    config: Path | None,
) -> None:
    """Show the frames that come over URL live: a serial port, a TCP stream, a CAN bus.

    One line per frame, with its time; bytes that are no frame are a FAULT. It sends nothing. A
    serial port is opened with the bit rate of the link's document, unless the URL has ?baud=. If a
    serve on this computer has the port, its own stream is shown instead.

    Exit 0 when the time is over or serve has ended; 1 if the port is missing or is lost.
    """
    from links.base import LinkError
    from mission.commands.decode import link_row, parse_options
    from mission.onboard.blackbox import BlackBoxError
    from mission.topside.hearing import Hearing, on_record

    row, tolerances = link_row(link_name), parse_options(options)
    hearing, shown = Hearing(row, tolerances), _Shown(as_json, raw)
    file = _new_file(record)
    try:
        for rx in _until(seconds, _source(url, link_name, config)):
            shown.show(hearing.receive(rx))
            if file is not None and rx.data:
                file.write(on_record(row, rx.data))
    except (LinkError, BlackBoxError) as error:
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
    finally:
        shown.show(hearing.end())
        if file is not None:
            file.close()
    click.echo(shown.count(), err=True)


def _until(seconds: float | None, heard: Iterator[Rx]) -> Iterator[Rx]:
    import time

    begun = time.monotonic()
    for rx in heard:
        yield rx
        if seconds is not None and time.monotonic() - begun >= seconds:
            return


def _source(url: str, link_name: str, config: Path | None) -> Iterator[Rx]:
    """The bytes of the port, or of the stream of the serve that has it. Raises LinkError."""
    import time

    from mission.onboard.configuration import ConfigurationError, load_configuration
    from mission.onboard.doctor.holder import holder
    from mission.topside.console import overhear
    from mission.topside.hearing import with_baud

    try:
        configuration = load_configuration(config)
    except ConfigurationError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None
    held = holder(url, configuration, time.time())
    if held is None:
        return overhear(with_baud(url, link_name))
    return _of_serve(held, link_name, configuration.folder)


def _of_serve(held: Holder, link_name: str, folder: Path) -> Iterator[Rx]:
    import time

    from mission.analysis.replay.follow import IN, OUT, follow
    from mission.onboard.serve import health

    def box() -> Path | None:
        told = health.read(folder, time.time())
        return Path(told["black_box"]) if told is not None and told["black_box"] else None

    if held.box is None:
        click.echo(f"serve (process {held.process}) has it, and records nothing", err=True)
        raise SystemExit(1)
    ways = (IN, OUT) if link_name in _BOTH else (OUT,) if link_name in _SAID else (IN,)
    click.echo(f"serve (process {held.process}) has it: this is its own stream", err=True)
    heard = follow(box, held.link, ways, time.time, time.sleep)
    return _one_of_two(heard, link_name == _BUS) if held.is_joined else heard


def _one_of_two(heard: Iterator[Rx], is_bus: bool) -> Iterator[Rx]:
    """Keep bus or line, of a link that joins both. serve drops what it receives on the bus."""
    from links.joined import is_of_bus
    from mission.analysis.replay.follow import OUT

    for rx in heard:
        is_here = is_bus == is_of_bus(rx.data) if rx.link == OUT else not is_bus
        yield rx if is_here else rx._replace(data=b"")


def _new_file(path: Path | None) -> BinaryIO | None:
    """Open a new file; an existing one is not overwritten (exit 2)."""
    if path is None:
        return None
    try:
        return path.open("xb", buffering=0)
    except OSError as error:
        click.echo(f"{path}: {error.strerror or error}", err=True)
        raise SystemExit(2) from None


class _Shown:
    def __init__(self, as_json: bool, raw: bool) -> None:
        self._as_json, self._raw = as_json, raw
        self._frames = self._faults = 0

    def show(self, found: Iterable[Heard]) -> None:
        from mission.topside.hearing import as_json, as_line

        form = as_json if self._as_json else as_line
        for heard in found:
            self._faults += heard.is_fault
            self._frames += not heard.is_fault
            click.echo(form(heard, self._raw))

    def count(self) -> str:
        return f"{self._frames} frames, {self._faults} faults"
