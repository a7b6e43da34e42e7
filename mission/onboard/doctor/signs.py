"""Check that the efforts move the vehicle as its file says: down by F, to starboard by Z (E-R8).

    wait for steady depth and heading, WAKE_S at most --> down 4 s --> rest --> to starboard 3 s
                                                      --> rest --> ahead 3 s --> neutral

The findings say what changed, and what the thrusters reported meanwhile. Use this in the water, on
a rope, with an observer, and only if no serve has the port. The reports show that depth and heading
follow the efforts. Only the observer sees that the bow went to starboard, and the vehicle ahead.

What does not live here: the control loop (onboard.runtime.outer_loop).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from links.base import Link, LinkError
from links.joined import open_whole
from mission.engine.thrust import MAINS, NEUTRAL
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.findings import Finding, fault, ok, warning
from mission.onboard.doctor.port_probe import listened, not_open
from protocol.messages import Setpoint, Telemetry
from protocol.vehicles import codec, vehicle_row
from protocol.vehicles.adapter import SilentBoard
from protocol.vehicles.keys import Key, read_wire

WHAT = "axes and signs"
REST_S, WAKE_S = 1.0, 60.0
AHEAD = 0.3  # share of full effort
_NEWEST = 5  # reports that are averaged
_AS_READ = (0.7, 1.4)  # accepted ratio of reported to commanded thrust
NO_LOOP = ok(WHAT, "not tried: the Pi closes no loop for this vehicle")


@dataclass(frozen=True, slots=True)
class Probe:
    """``effort`` for ``seconds`` must increase ``reading`` by ``least``; "": an observer looks."""

    reading: str
    effort: Setpoint
    seconds: float
    least: float
    key: str  # of ``wire``, that reverses the sign

    def told(self, grown: float) -> str:
        shown = f"{math.degrees(grown):.0f} deg" if self.reading == "heading" else f"{grown:.2f} m"
        return f"the {self.reading} changed by {shown}"


def probes_of(vehicle: Vehicle) -> tuple[Probe, ...]:
    """The probes of a vehicle; () if the Pi closes no loop for it."""
    loop = vehicle.outer_loop
    if loop is None:
        return ()
    return (
        Probe("depth", Setpoint(heave=loop.depth.most), 4.0, 0.1, "f_sign"),
        Probe("heading", Setpoint(turn=loop.heading.most), 3.0, math.radians(5.0), "z_sign"),
        Probe("", Setpoint(surge=AHEAD), 3.0, 0.0, "x_sign"),
    )


def needless(vehicle: Vehicle) -> Finding | None:
    """The finding if this vehicle cannot be tried; None if it can be."""
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
        probes = probes_of(vehicle)
        if why := _waited(probes, link, board):
            todo = "let it lie still in the water until its sensors are awake, and try again"
            yield warning(WHAT, f"{why}: nothing was tried", todo)
            return
        for probe in probes:
            yield from _found(probe, link, board, vehicle)
        _say(link, board, Setpoint(), REST_S)
    except LinkError as error:
        yield fault(WHAT, str(error), "check cable and plug, then run doctor again")
    finally:
        link.close()


def _waited(probes: Sequence[Probe], link: Link, board: SilentBoard) -> str:
    """Wait until it is ready; why it is not after WAKE_S, "" if it is or reports nothing."""
    begun = time.monotonic()
    while True:
        why = _unready(probes, _say(link, board, Setpoint(), REST_S))
        if not why or time.monotonic() >= begun + WAKE_S:
            return why


def _unready(probes: Sequence[Probe], heard: Sequence[Telemetry]) -> str:
    if heard and dict(heard[-1].board).get("ins_aligned", 1) != 1:
        return "the INS is not aligned"
    for probe in probes:
        values, half = _series(heard, probe.reading), len(heard) // 2
        if len(values) == len(heard) > 1:
            moved = _mean(values[half:]) - _mean(values[:half])
            if abs(moved) >= probe.least:
                return f"{probe.told(moved)} within {REST_S:g} s of rest"
    return ""


def _found(probe: Probe, link: Link, board: SilentBoard, vehicle: Vehicle) -> Iterator[Finding]:
    rested = _say(link, board, Setpoint(), REST_S)
    if probe.reading and not _series(rested, probe.reading):
        todo = "look at the board's sensors first"
        yield fault(WHAT, f"no {probe.reading} in the reports", todo)
        return
    pushed = _say(link, board, probe.effort, probe.seconds)
    yield _moved(probe, rested, pushed, vehicle.codec)
    yield from _turned_at(probe, pushed, vehicle)


def _moved(
    probe: Probe, rested: list[Telemetry], pushed: list[Telemetry], codec_name: str
) -> Finding:
    if not probe.reading:
        said = f"it was pushed ahead with {probe.effort.surge:.0%} for {probe.seconds:g} s"
        return ok(WHAT, said, f"if you saw it go astern, {turned(probe, codec_name)}")
    before = _series(rested, probe.reading)
    after = _series(rested + pushed, probe.reading)[len(before) :]
    if not after:
        todo = "look at the board's sensors first"
        return fault(WHAT, f"no {probe.reading} in the reports while it was pushed", todo)
    grown = _mean(after[-_NEWEST:]) - _mean(before[-_NEWEST:])
    if grown >= probe.least:
        todo = "if you saw it so, down and the bow to starboard, write today's date as `confirmed:`"
        return ok(WHAT, probe.told(grown), f"{todo} under outer_loop")
    if grown <= -probe.least:
        return fault(WHAT, f"{probe.told(grown)}: the wrong way", turned(probe, codec_name))
    todo = "put it into water, free of ground and walls, and try again"
    return warning(WHAT, f"{probe.told(grown)}: too little to tell", todo)


def _turned_at(probe: Probe, pushed: list[Telemetry], vehicle: Vehicle) -> Iterator[Finding]:
    """Warn of thrusters that do not report the effort, with the full speed that would match."""
    keys = vehicle_row(vehicle.codec).keys
    full = [key for key in keys if isinstance(key, Key) and key.name.endswith("_rpm")]
    told = [r.actuators for r in pushed[-_NEWEST:] if r.actuators is not None]
    if not full or not told:
        return
    wire, effort = read_wire(keys, vehicle.wire), probe.effort
    asked = (effort.surge + effort.turn, effort.surge - effort.turn)
    said, write = [], []
    for n, key in enumerate(full):
        due = asked[n] if n < MAINS else -(effort.heave or 0.0)
        seen = _mean([shares[n] for shares in told])
        if due == 0.0 or _AS_READ[0] <= seen / due <= _AS_READ[1]:
            continue
        rpm = round(wire[key.name] * seen / due) if abs(seen) > NEUTRAL else 0
        said.append(
            f"{key.name.removesuffix('_rpm')} reports {seen:+.0%} where it was told {due:+.0%}"
        )
        write.append(f"{key.name}: {max(-int(key.high), min(rpm, int(key.high)))}")
    if said:
        yield warning(WHAT, ", ".join(said), f"write `wire: {{{', '.join(write)}}}`, and try again")


def turned(probe: Probe, codec_name: str) -> str:
    """How to reverse the sign: by a key of the vehicle file, if there is one."""
    if any(key.name == probe.key for key in vehicle_row(codec_name).keys):
        return f"write `wire: {{{probe.key}: -1}}` into the vehicle file, and try again"
    return "turn it round at the motor boards (the vehicle file has no key for it), and try again"


def _say(link: Link, board: SilentBoard, effort: Setpoint, seconds: float) -> list[Telemetry]:
    """Send the frames every period for ``seconds``; return the reports that came meanwhile."""
    heard: list[Telemetry] = []
    begun = time.monotonic()
    while (now := time.monotonic()) < begun + seconds:
        for frame in board.encode(effort):  # one by one: they may go to several boards
            link.send(frame, now)
        due = now + board.period
        for data, t in listened(link, lambda due=due: time.monotonic() >= due):  # type: ignore[misc]
            heard += [one for one in board.receive(data, t) if isinstance(one, Telemetry)]
    return heard


def _series(reports: Sequence[Telemetry], reading: str) -> list[float]:
    """The values in order; headings are unwrapped."""
    values = [value for r in reports if (value := getattr(r, reading, None)) is not None]
    if reading == "heading":
        for i in range(1, len(values)):
            values[i] = values[i - 1] + math.remainder(values[i] - values[i - 1], math.tau)
    return values


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
