"""``auvmission monitor``: what a running serve shows to viewers, one JSON object per line."""

from __future__ import annotations

import json
import time

import click

from mission.commands.options import LinkUrl

MONITOR = "tcp://127.0.0.1:4001"


def beside(url: str, ports: int) -> str:
    """The URL with the port ``ports`` further: the monitor's is the one after the operator's. "" if
    the URL has no port of a host. Raises LinkAddressError."""
    from links import parse_address

    address = parse_address(url)
    if address.scheme not in ("tcp", "tls") or address.port is None:
        return ""
    return url.replace(f":{address.port}", f":{address.port + ports}", 1)


@click.command()
@click.argument("url", type=LinkUrl(), default=MONITOR)
@click.option("--rate", type=click.FloatRange(0.0, min_open=True), default=5.0, show_default=True,
              metavar="HZ", help="Frames a second, at most.")  # fmt: skip
@click.option("--bytes", "most", type=click.IntRange(1), default=16_000, show_default=True,
              help="Of one frame, at most.")  # fmt: skip
@click.option("--value", "values", multiple=True, metavar="NAME",
              help="Of the state only this; repeatable. For a thin radio.")  # fmt: skip
@click.option("--track/--no-track", default=True, help="The track so far, and on.")
@click.option("--plan/--no-plan", default=True, help="The mission in the store.")
@click.option("--for", "seconds", default=0.0, metavar="SECONDS", help="End after so long.")
def monitor(
    url: str,
    rate: float,
    most: int,
    values: tuple[str, ...],
    track: bool,
    plan: bool,
    seconds: float,
) -> None:
    """Print live what serve shows to viewers at URL: changes of state, events, plan, track.

    Nothing sent here can command the vehicle. Times are the engine's, in s.

    Exit 0 when the time is over, 1 if there is no monitor, it is lost, or it sends nothing.
    """
    from links.base import LinkError
    from mission.topside.console import observe
    from mission.topside.monitor import NoMonitor, Watched, wish

    asked, watched = wish(rate, most, values, track=track, plan=plan), Watched()
    end = time.monotonic() + seconds if seconds else float("inf")
    try:
        for frame in observe(url, asked, watched):
            if frame is not None:
                click.echo(json.dumps(frame))
            if time.monotonic() >= end:
                break
        if watched.at is None:
            raise NoMonitor(f"nothing was told for {seconds:g} s: is {url} the operator's port?")
    except (LinkError, NoMonitor) as error:
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
