"""Whether the efforts move the vehicle as its file says: down by F, to starboard by Z (E-R8).

    rest 1 s --> down 4 s --> rest --> to starboard 3 s --> neutral      what changed is told

In the water, on a rope, with a person who looks: the reports say that depth and heading follow the
efforts, and only the person sees that the bow went to starboard. Only where no serve has the port.

What does not live here: the loop that is then closed (onboard.runtime.outer_loop).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

from links.base import Link, LinkError
from links.joined import open_whole
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.findings import Finding, fault, ok, warning
from mission.onboard.doctor.port_probe import listened, not_open
from protocol.messages import Setpoint, Telemetry
from protocol.vehicles import codec, vehicle_row
from protocol.vehicles.adapter import SilentBoard

WHAT = "axes and signs"
REST_S = 1.0
NO_LOOP = ok(WHAT, "not tried: the Pi closes no loop for this vehicle")


@dataclass(frozen=True, slots=True)
class Probe:
    """``effort`` for ``seconds`` has to make ``reading`` grow by ``least``."""

    reading: str
    effort: Setpoint
    seconds: float
    least: float
    key: str  # of ``wire``, that turns the sign round

    def told(self, grown: float) -> str:
        shown = f"{math.degrees(grown):.0f} deg" if self.reading == "heading" else f"{grown:.2f} m"
        return f"the {self.reading} changed by {shown}"


def probes_of(vehicle: Vehicle) -> tuple[Probe, ...]:
    """None where the Pi closes no loop."""
    loop = vehicle.outer_loop
    if loop is None:
        return ()
    return (
        Probe("depth", Setpoint(heave=loop.depth.most), 4.0, 0.1, "f_sign"),
        Probe("heading", Setpoint(turn=loop.heading.most), 3.0, math.radians(5.0), "z_sign"),
    )


def needless(vehicle: Vehicle) -> Finding | None:
    """Why nothing is tried with this vehicle; None: it can be."""
    return NO_LOOP if vehicle.outer_loop is None else None


def sign_findings(url: str, vehicle: Vehicle) -> Iterator[Finding]:
    board = codec(*vehicle.speaks)
    if vehicle.outer_loop is None or not isinstance(board, SilentBoard):
        yield NO_LOOP
        return
    board.take_outputs(vehicle.safe_levels)
    try:
        link = open_whole("vehicle", url)
    except LinkError as error:
        yield not_open(WHAT, url, error)
        return
    try:
        found = [_found(probe, link, board, vehicle.codec) for probe in probes_of(vehicle)]
        _say(link, board, Setpoint(), REST_S)
        yield from found
    except LinkError as error:
        yield fault(WHAT, str(error), "check cable and plug, then run doctor again")
    finally:
        link.close()


def _found(probe: Probe, link: Link, board: SilentBoard, codec_name: str) -> Finding:
    before = _mean(_say(link, board, Setpoint(), REST_S), probe.reading)
    after = _mean(_say(link, board, probe.effort, probe.seconds)[-5:], probe.reading)
    if before is None or after is None:
        return fault(
            WHAT, f"no {probe.reading} in the reports", "look at the board's sensors first"
        )
    circular = probe.reading == "heading"
    grown = math.remainder(after - before, math.tau) if circular else after - before
    if grown >= probe.least:
        todo = "if you saw it so, down and the bow to starboard, write today's date as `confirmed:`"
        return ok(WHAT, probe.told(grown), f"{todo} under outer_loop")
    if grown <= -probe.least:
        return fault(WHAT, f"{probe.told(grown)}: the wrong way", turned(probe, codec_name))
    todo = "put it into water, free of ground and walls, and try again"
    return warning(WHAT, f"{probe.told(grown)}: too little to tell", todo)


def turned(probe: Probe, codec_name: str) -> str:
    """What turns it round: a key of the vehicle file, where its frames have one."""
    if any(key.name == probe.key for key in vehicle_row(codec_name).keys):
        return f"write `wire: {{{probe.key}: -1}}` into the vehicle file, and try again"
    return "turn it round at the motor boards (the vehicle file has no key for it), and try again"


def _say(link: Link, board: SilentBoard, effort: Setpoint, seconds: float) -> list[Telemetry]:
    """The frames every period; what was reported meanwhile."""
    heard: list[Telemetry] = []
    begun = time.monotonic()
    while (now := time.monotonic()) < begun + seconds:
        for frame in board.encode(effort):  # each by itself: they may go to several boards
            link.send(frame, now)
        due = now + board.period
        for data, t in listened(link, lambda due=due: time.monotonic() >= due):  # type: ignore[misc]
            heard += [one for one in board.receive(data, t) if isinstance(one, Telemetry)]
    return heard


def _mean(reports: list[Telemetry], reading: str) -> float | None:
    """Of the newest ones; headings about the first of them."""
    values = [value for r in reports[-5:] if (value := getattr(r, reading)) is not None]
    if not values:
        return None
    off = (
        math.remainder(v - values[0], math.tau) if reading == "heading" else v - values[0]
        for v in values
    )
    return float(values[0] + sum(off) / len(values))
