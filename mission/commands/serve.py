"""``auvmission serve``: the Pi's program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mission.configuration import Configuration, LinkUrls
    from mission.model import Estimate, Step
    from mission.serve.printer import Printer
    from mission.serve.serve import Ready


@click.command()
@click.option(
    "-c", "--config", type=click.Path(path_type=Path), help="YAML file; all has defaults."
)
@click.option("--vehicle", metavar="URL", help="Link to the STM32, e.g. serial:///dev/ttyUSB0.")
@click.option("--gps", metavar="URL", help="Link to the GPS receiver; 'none' for none.")
@click.option("--topside", metavar="URL", help="Where to listen, e.g. tcp://127.0.0.1:4000.")
@click.option("--folder", type=click.Path(path_type=Path), help="For store/ and log/.")
@click.option("--speed", type=click.FloatRange(min=0.01), default=1.0, show_default=True,
              help="Time factor of a demonstration; the same for all its processes.")  # fmt: skip
@click.option("--ready-file", type=click.Path(path_type=Path),
              help="Written as JSON once operators can connect.")  # fmt: skip
@click.option("--events", is_flag=True, help="Every step and estimate as a JSON line on stdout.")
def serve(
    config: Path | None,
    vehicle: str | None,
    gps: str | None,
    topside: str | None,
    folder: Path | None,
    speed: float,
    ready_file: Path | None,
    events: bool,
) -> None:
    """Receive missions, fly them, answer the boat: the program that runs on the Pi.

    Ends with SIGINT or SIGTERM: with the vehicle under way it brings it up first, and ends at once
    if told again. Links given here overrule the configuration's.
    """
    import json
    import os
    import time

    from links.base import LinkError
    from mission.configuration import ConfigurationError, load_configuration
    from mission.serve.journal import printed
    from mission.serve.leaving import time_to_leave
    from mission.serve.only import AnotherServe, only_one
    from mission.serve.printer import Printer
    from mission.serve.serve import Server, run
    from mission.store import DiskStore, StoreError
    from mission.vehicle import VehicleError, load_vehicle

    def tell(line: str) -> None:
        click.echo(printed(line.rstrip(), time.time()), err=True)

    def ready(what: Ready) -> None:
        said = json.dumps({"topside": what.topside, "black_box": what.black_box})
        out.print(said if events else f"listening for the topside on {what.topside}")
        if ready_file is not None:
            try:
                _write_whole(ready_file, said + "\n")
            except OSError as error:  # a disk that is full is no reason to be deaf
                err.print(printed(f"warning: {ready_file}: {error.strerror}", time.time()))

    given = {"vehicle": vehicle, "gps": gps, "topside": topside}
    try:
        configuration = _configured(load_configuration(config), given, folder)
        flown = load_vehicle(configuration.vehicle)
        store = DiskStore(configuration.store)
    except (ConfigurationError, LinkError, VehicleError, StoreError) as error:
        tell(f"fault: {error}")
        raise SystemExit(2) from None
    for damage in store.content.damage:
        tell(f"warning: {damage}")
    out, err = Printer(1, waiting=100_000), Printer(2)
    observer = _Events(out) if events else None
    server = Server(
        configuration,
        flown,
        store,
        lambda line: err.print(printed(line.rstrip(), time.time())),
        ready,
        speed,
        observer,
        time_to_leave(os.environ),
    )
    try:
        with only_one(configuration.folder):
            run(server)
    except AnotherServe as error:
        server.refusal = str(error)
    finally:
        out.close()
        err.close()
    if server.refusal:
        tell(f"fault: {server.refusal}")
        raise SystemExit(2)


def _configured(
    configuration: Configuration, given: dict[str, str | None], folder: Path | None
) -> Configuration:
    """``given`` are the links of the command line. Raises LinkAddressError."""
    from dataclasses import replace

    urls = {n: None if n == "gps" and u == "none" else u for n, u in given.items() if u}
    links = replace(configuration.links, **urls)  # type: ignore[arg-type]
    _check(links)
    return replace(configuration, links=links, folder=folder or configuration.folder)


def _write_whole(path: Path, text: str) -> None:
    """Whoever reads meanwhile finds all of it or nothing."""
    beside = path.with_name(path.name + ".new")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


def _check(links: LinkUrls) -> None:
    """Raises LinkAddressError for what is no URL of a link; whether it opens is seen later."""
    from links import parse_address
    from mission.serve.listening import listening

    for url in (links.vehicle, links.gps, listening(links.topside), links.modem):
        if url is not None:
            parse_address(url)


class _Events:
    """What the drive decides, as JSON lines."""

    def __init__(self, out: Printer) -> None:
        self._out = out

    def step(self, step: Step) -> None:
        from mission.drive.records import step_record

        self._say("step", step_record(step).payload)

    def estimate(self, estimate: Estimate) -> None:
        from mission.drive.records import estimate_record

        self._say("estimate", estimate_record(estimate).payload)

    def _say(self, kind: str, payload: bytes) -> None:
        self._out.print(f'{{"{kind}":{payload.decode()}}}')
