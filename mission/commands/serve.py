"""``auvmission serve``: the program on the Pi."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mission.model import Estimate, Step
    from mission.onboard.serve.listening import Ready
    from mission.onboard.serve.printer import Printer
    from mission.onboard.serve.provision import Provision


@click.command()
@click.option(
    "-c", "--config", type=click.Path(path_type=Path), help="YAML file; all has defaults."
)
@click.option("--vehicle", metavar="URL", help="Link to the STM32, e.g. serial:///dev/ttyUSB0.")
@click.option("--gps", metavar="URL", help="Link to the GPS receiver; 'none' for none.")
@click.option("--topside", metavar="URL",
              help="Where to listen, e.g. tcp-listen://127.0.0.1:4000.")  # fmt: skip
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

    Ends on SIGINT or SIGTERM. If the vehicle is under way, serve brings it up first; a second
    signal ends serve at once. Links given here override the configuration's.
    """
    import json
    import os
    import time

    from mission.onboard.serve.closing import close_in_background
    from mission.onboard.serve.foreground import run
    from mission.onboard.serve.instance_lock import AnotherServe, only_one
    from mission.onboard.serve.journal import printed
    from mission.onboard.serve.leaving import time_to_leave
    from mission.onboard.serve.printer import Printer
    from mission.onboard.serve.serve import Server

    def ready(what: Ready) -> None:
        said = json.dumps({"topside": what.topside, "black_box": what.black_box})
        out.print(said if events else f"listening for the topside on {what.topside}")
        if ready_file is not None:
            try:
                _write_whole(ready_file, said + "\n")
            except OSError as error:  # serve must run although the disk is full
                err.print(printed(f"warning: {ready_file}: {error.strerror}", time.time()))

    got = _provided(config, {"vehicle": vehicle, "gps": gps, "topside": topside}, folder)
    out, err = Printer(1, waiting=100_000), Printer(2)
    observer = _Events(out) if events else None
    server = Server(
        got,
        lambda line: err.print(printed(line.rstrip(), time.time())),
        ready,
        speed,
        observer,
        time_to_leave(os.environ),
        close_in_background,
    )
    refusal = ""
    try:
        with only_one(got.configuration.folder):
            run(server)
    except AnotherServe as error:
        refusal = str(error)
    finally:
        out.close()
        err.close()
    if refusal:
        _tell(f"fault: {refusal}")
        raise SystemExit(2)


def _provided(
    config: Path | None, given: Mapping[str, str | None], folder: Path | None
) -> Provision:
    """What serve runs with. Prints the faults in it. Exit 2 if serve cannot run at all."""
    from mission.onboard.serve.provision import Unusable, provide

    try:
        got = provide(config, given, folder)
    except Unusable as error:
        _tell(f"fault: {error}")
        raise SystemExit(2) from None
    for broken in got.faults:
        _tell(f"fault: {broken}")
    if got.configuration.ascent_only:
        _tell(f"warning: {got.configuration.ascent_only}")
    for damage in got.damage:
        _tell(f"warning: {damage}")
    return got


def _tell(line: str) -> None:
    """Print a line while no printer runs: before it starts, and after it has ended."""
    import time

    from mission.onboard.serve.journal import printed

    click.echo(printed(line.rstrip(), time.time()), err=True)


def _write_whole(path: Path, text: str) -> None:
    """Write the file so that a reader finds all of it or nothing."""
    beside = path.with_name(path.name + ".new")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


class _Events:
    """Print what the runtime decides, as JSON lines."""

    def __init__(self, out: Printer) -> None:
        self._out = out

    def step(self, step: Step) -> None:
        from mission.onboard.runtime.records import step_record

        self._say("step", step_record(step).payload)

    def estimate(self, estimate: Estimate) -> None:
        from mission.onboard.runtime.records import estimate_record

        self._say("estimate", estimate_record(estimate).payload)

    def notice(self, text: str) -> None:
        """Ignore notices."""

    def _say(self, kind: str, payload: bytes) -> None:
        self._out.print(f'{{"{kind}":{payload.decode()}}}')
