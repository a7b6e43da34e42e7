"""Listen to the vehicle, its receivers and added sensors for `doctor`, if no serve has the ports.

It sends one harmless query, ``@RI`` (which sensors are powered), to a vehicle that knows it, and no
setpoint or order. What does not live here: the computer's own state (doctor).
"""

from __future__ import annotations

import math
import select
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from links import LinkAddressError, open_link
from links.base import Link, LinkBusy, LinkError
from links.joined import open_whole
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.boards import board, trip
from mission.onboard.doctor.findings import Finding, fault, ok, warning
from protocol.added import GROUND, PLACE, RANGE, WATER, AddedDecoder
from protocol.codec import Received
from protocol.messages import Ack, Aid, Fix, FrameFault, Telemetry
from protocol.nmea import NmeaDecoder
from protocol.vehicles import codec

LISTEN_S = 5.0  # s, for the first report
REPORTS = 3  # enough to show a frozen sensor
LONGEST_S = 9.0
GPS_S = 3.0
SENSORS_S = 6.0  # s: an acoustic system sends a position every 5 s
QUERY = b"@RI$"
_REPORT = b"@SD"
_SWAPPED = (
    "swap links.vehicle and links.gps, or the plugs; a name of /dev/serial/by-id stays with its "
    "device"
)
_ADDED = {
    WATER: "speed through the water",
    GROUND: "speed over ground",
    PLACE: "a place",
    RANGE: "the way from a beacon",
}
NAMES = ("depth", "altitude", "heading", "pitch", "roll")
_DEEPEST_ON_DECK, _ROLLED = 0.5, math.radians(60.0)


def vehicle_findings(url: str, vehicle: Vehicle) -> list[Finding]:
    try:
        link = open_whole("vehicle", url)
    except LinkError as error:
        return [not_open("vehicle port", url, error)]
    raw = bytearray()
    try:
        heard = _listen(link, vehicle, raw)
    except LinkError as error:
        return [fault("vehicle port", str(error), "check cable and plug, then run doctor again")]
    finally:
        link.close()
    port = ok("vehicle port", f"{url} is there, permitted and free")
    return [port, *of_vehicle(vehicle, heard, bytes(raw))]


def port_finding(what: str, url: str) -> Finding:
    """Check that the port can be opened; nothing is sent or read."""
    try:
        open_whole(what, url).close()
    except LinkError as error:
        return not_open(what, url, error)
    return ok(what, f"{url} is there, permitted and free")


def gps_findings(url: str, name: str = "gps") -> list[Finding]:
    """Listen to the GPS receiver of this link, the first or ``gps2``."""
    port = "GPS port" if name == "gps" else f"{name} port"
    try:
        link = open_link(name, url)
    except LinkError as error:
        return [not_open(port, url, error)]
    decoder, heard, raw = NmeaDecoder(), list[Fix | FrameFault](), bytearray()
    try:
        begun = time.monotonic()
        for data, now in listened(link, lambda: time.monotonic() - begun >= GPS_S):
            heard += decoder.receive(data, now)
            raw += data
        heard += decoder.flush(time.monotonic())
    except LinkError as error:
        return [fault(port, str(error), "check cable and plug, then run doctor again")]
    finally:
        link.close()
    return [
        ok(port, f"{url} is there, permitted and free"),
        replace(of_gps(decoder, heard, bytes(raw)), what=port.removesuffix(" port")),
    ]


def of_gps(decoder: NmeaDecoder, heard: Sequence[Fix | FrameFault], raw: bytes) -> Finding:
    fixes = [one for one in heard if isinstance(one, Fix)]
    faults = len(heard) - len(fixes)
    if fixes:
        last = fixes[-1]
        dop = f", HDOP {last.hdop:g}" if last.hdop is not None else ""
        if last.hdop is not None and last.hdop > 3.0:
            return warning("GPS", f"a fix{dop}", "wait for a better one: a start needs HDOP <= 3")
        return ok("GPS", f"{len(fixes)} fixes in {GPS_S:g} s{dop}")
    if decoder.counters.sentences:
        return warning(
            "GPS",
            f"sentences, but no valid fix (and {faults} faulty ones)",
            "put the antenna under the open sky and wait; a mission without a fix "
            "starts only if it says so",
        )
    if _REPORT in raw:
        return fault("GPS", "this is the STM32: it sends @SD", _SWAPPED)
    return fault(
        "GPS",
        f"no sentence in {GPS_S:g} s ({len(raw)} bytes, {faults} faulty sentences)",
        "check power, cable and baud rate (?baud=) of the receiver",
    )


def sensors_findings(url: str) -> list[Finding]:
    """Listen to the line of added sensors."""
    try:
        link = open_link("sensors", url)
    except LinkError as error:
        return [not_open("sensors port", url, error)]
    decoder, heard, length = AddedDecoder(), list[Aid | FrameFault](), 0
    try:
        begun = time.monotonic()
        for data, now in listened(link, lambda: time.monotonic() - begun >= SENSORS_S):
            heard += decoder.receive(data, now)
            length += len(data)
    except LinkError as error:
        return [fault("sensors port", str(error), "check cable and plug, then run doctor again")]
    finally:
        link.close()
    return [
        ok("sensors port", f"{url} is there, permitted and free"),
        of_sensors(heard, length),
    ]


def of_sensors(heard: Sequence[Aid | FrameFault], length: int) -> Finding:
    """Judge what was received. ``length``: number of bytes."""
    what = "added sensors"
    kinds = {one.kind for one in heard if isinstance(one, Aid)}
    faults = sum(isinstance(one, FrameFault) for one in heard)
    if kinds:
        names = ", ".join(name for kind, name in _ADDED.items() if kind in kinds)
        return ok(what, f"{names} in {SENSORS_S:g} s, {faults} faulty lines")
    if length and not faults:
        return warning(
            what,
            f"lines, but no value in {SENSORS_S:g} s",
            "in air a Doppler log and an acoustic system may have none: look again in the water",
        )
    return fault(
        what,
        f"no line in {SENSORS_S:g} s that can be read ({length} bytes, {faults} faulty lines)",
        "check power, cable and baud rate (?baud=); docs/operation.md has the sentences",
    )


def _listen(link: Link, vehicle: Vehicle, raw: bytearray) -> list[Received]:
    """Send the query, and listen until REPORTS reports and its answer have come or the time is
    over."""
    decoder = codec(*vehicle.speaks)
    heard: list[Received] = []
    begun = time.monotonic()
    if vehicle.codec == "auv":
        link.send(QUERY, begun)

    def enough() -> bool:
        passed = time.monotonic() - begun
        reports = sum(isinstance(one, Telemetry) for one in heard)
        complete = reports >= REPORTS and (vehicle.codec != "auv" or bool(_answers(heard)))
        return passed >= LONGEST_S or complete or (not reports and passed >= LISTEN_S)

    for data, now in listened(link, enough):
        heard += decoder.receive(data, now)
        raw += data
    return heard


def _answers(heard: Sequence[Received]) -> list[Ack]:
    """The answers to the query."""
    return [one for one in heard if isinstance(one, Ack) and one.group == "R"]


def listened(link: Link, over: Callable[[], bool]) -> Iterator[tuple[bytes, float]]:
    while not over():
        select.select([link.fileno()] if link.fileno() >= 0 else [], [], [], 0.1)
        now = time.monotonic()
        for rx in link.receive(now):
            yield rx.data, now


def of_vehicle(vehicle: Vehicle, heard: Sequence[Received], raw: bytes = b"") -> Iterator[Finding]:
    reports = [one for one in heard if isinstance(one, Telemetry)]
    faults = sum(isinstance(one, FrameFault) for one in heard)
    if not reports:
        yield _no_report(raw, faults, vehicle)
    else:
        yield ok("vehicle", f"reports ({len(reports)} good, {faults} faulty frames)")
    if vehicle.codec == "auv":
        if _answers(heard):
            yield ok("vehicle answers", "the STM32 answers @RI")
        else:
            yield fault(
                "vehicle answers",
                "no answer to @RI",
                "what the Pi sends does not arrive: check its TX line to the STM32",
            )
    if reports:
        yield from (_sensor(name, reports, vehicle) for name in NAMES)
        yield from _margins(reports[-1], vehicle)


def _no_report(raw: bytes, faults: int, vehicle: Vehicle) -> Finding:
    """What is on the line instead of reports, as far as it can be recognised."""
    its, decoder = board(vehicle), NmeaDecoder()
    decoder.receive(raw, 0.0)
    if decoder.counters.sentences:
        return fault("vehicle", "this is a GPS receiver: it sends NMEA sentences", _SWAPPED)
    if QUERY in raw:
        says = "what the Pi sends comes back to it"
        todo = f"TX and RX are joined, or this is not {its.name}: check the plug"
        return fault("vehicle", says, todo)
    if not its.reports:
        return ok("vehicle", f"{its.name}: {its.quiet}; see {its.moves} move (auvmission stick)")
    says = f"no report within {LISTEN_S:g} s ({len(raw)} bytes, {faults} faulty frames)"
    if _REPORT in raw and vehicle.codec != "auv":
        todo = "the vehicle file is another vehicle's: set `vehicle:` to one for the AUV"
        return fault("vehicle", f"{says}: this is the AUV's STM32, it sends @SD", todo)
    if faults:
        manual = f", and whether {its.quiet}" if its.quiet else ""
        return fault(
            "vehicle",
            says,
            "it sends something else: check `vehicle:`, dialect and tolerances of the vehicle "
            f"file, baud rate{manual}",
        )
    dead = f"check its power and the serial cable (RX and TX crossed?); restart {its.name}"
    return fault("vehicle", says, dead)


def _sensor(name: str, reports: Sequence[Telemetry], vehicle: Vehicle) -> Finding:
    what = f"sensor {name}"
    needed = name if name in ("depth", "altitude", "heading") else "attitude"
    values = [getattr(report, name) for report in reports]
    there = [value for value in values if value is not None]
    if not there:
        if needed not in vehicle.reports:
            return ok(what, "absent, as the vehicle file says")
        return fault(
            what,
            "silent",
            f"check its cable and power ({board(vehicle).switch}), or declare it absent in the "
            "vehicle file: limits that need it are then disarmed",
        )
    shown = _shown(name, there[-1])
    if name == "roll" and abs(there[-1]) > _ROLLED:
        return warning(what, f"{shown} on deck", "lay the vehicle level, and look again")
    if name == "depth" and abs(there[-1]) > _DEEPEST_ON_DECK:
        return warning(
            what,
            f"{shown}, and a dry vehicle has none",
            "if it is not in the water: check the pressure sensor's zero",
        )
    if len(there) >= REPORTS and len(set(there)) == 1:
        return warning(
            what,
            f"{shown}, the same to the last bit in {len(there)} reports",
            "move the vehicle and see it change; if not, the sensor is dead",
        )
    return ok(what, f"{shown}, alive" if len(set(there)) > 1 else shown)


def _shown(name: str, value: float) -> str:
    return f"{value:.2f} m" if name in ("depth", "altitude") else f"{math.degrees(value):.1f} deg"


def _margins(report: Telemetry, vehicle: Vehicle) -> Iterator[Finding]:
    volts = report.batteries[0] if report.batteries else None
    if volts is not None and not vehicle.constant_batteries:
        left = volts - vehicle.limits.voltage
        says = f"{volts:.1f} V, {left:.1f} V above the hard limit"
        if left < 1.0:
            yield warning("margin voltage", says, f"charge before the {trip(vehicle)}")
        else:
            yield ok("margin voltage", says)


def not_open(what: str, url: str, error: LinkError) -> Finding:
    if isinstance(error, LinkBusy):
        return fault(what, str(error), f"see who has it: fuser {url.partition('://')[2]}")
    if isinstance(error, LinkAddressError):
        return fault(what, str(error), "mend `links:` of the configuration, then run doctor again")
    return fault(what, str(error), "mend that, then run doctor again")
