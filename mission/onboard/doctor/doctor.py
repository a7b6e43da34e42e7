"""Checks of this Pi and its vehicle before a dive: a table of checks, each with its findings.

If a serve runs, `doctor` leaves its ports alone, and judges the health that serve has written.
What does not live here: listening to the vehicle (port_probe), printing (the command).
"""

from __future__ import annotations

import errno
import math
import os
import shlex
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from links import parse_address
from links.base import LinkError
from mission import __version__
from mission.engine.bounds import in_force
from mission.engine.restart import STOPS
from mission.model.compiled import build
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.doctor import asking, port_probe, signs
from mission.onboard.doctor.boards import at_rest, board, trip
from mission.onboard.doctor.buoyant import buoyant
from mission.onboard.doctor.findings import Condition, Finding, fault, ok, warning
from mission.onboard.doctor.vehicle_file import assumed, never_acting
from mission.onboard.serve import health
from mission.onboard.serve.listening import listening, open_to_all
from mission.onboard.store import DiskStore, StoreError

MUCH, LITTLE = 2 << 30, 200 << 20  # bytes free, for the black boxes of a day, of an hour
YEARS = range(2024, 2100)
_SILENT = {
    "vehicle": 5.0,
    "gps": 5.0,
    "gps2": 5.0,
    "sensors": 30.0,
}  # s without a byte, on links that send unasked


@dataclass(frozen=True, slots=True)
class CheckContext:
    """``running``: the health that a running serve has written. ``mute``: the process of a serve
    that runs, but writes no health. ``ask``: the board may be sent an X. ``move``: the vehicle may
    be moved, in the water."""

    configuration: Configuration
    vehicle: Vehicle
    running: Mapping[str, Any] | None
    mute: int | None = None
    ask: bool = False
    move: bool = False


def examine(
    configuration: Configuration, vehicle: Vehicle, *, ask: bool = False, move: bool = False
) -> Iterator[Finding]:
    """Run the checks in the order of ROWS; yield each finding at once."""
    folder, now = configuration.folder, time.time()
    running, mute = health.read(folder, now), health.mute(folder, now)
    context = CheckContext(configuration, vehicle, running, mute, ask, move)
    for check in ROWS:
        yield from check(context)


def _configured(context: CheckContext) -> Iterator[Finding]:
    c = context.configuration
    if c.ascent_only:
        says = f"{c.ascent_only}; with the folder {c.folder} and the vehicle at {c.links.vehicle}"
        yield warning("configuration", says, "mend what is broken, then restart serve")
    else:
        yield ok("configuration", f"read; vehicle file {c.vehicle}, folder {c.folder}")
    if context.mute is not None:
        yield fault(
            "serve",
            f"process {context.mute} runs, but has not told of its health for {health.STALE_S:g} s",
            "free the disk if it is full, mend it if it is read-only; else restart serve, with the"
            f" vehicle {at_rest(context.vehicle)}",
        )
    elif context.running is None:
        yield ok("serve", "not running; doctor listens to the ports itself")
    else:
        yield ok(
            "serve",
            f"running (process {context.running['pid']}, "
            f"{context.running['state']}): its ports are left alone",
        )
        for broken in context.running["broken"]:
            todo = f"mend it, then, with the vehicle {at_rest(context.vehicle)}, restart serve"
            yield fault("serve began with", broken, todo)


def _disk(context: CheckContext) -> Iterator[Finding]:
    folder = context.configuration.folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".doctor-") as file:
            file.write(b"x")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        says = f"{folder} cannot be written: {error.strerror}"
        yield fault("folder", says, _remedy(error, folder))
        return
    yield ok("folder", f"{folder} can be written")
    free = shutil.disk_usage(folder).free
    says = f"{free / 2**30:.1f} GiB free"
    if free < LITTLE:
        yield fault("disk", says, f"move old black boxes from {folder / 'log'} to another computer")
    elif free < MUCH:
        yield warning("disk", says, f"soon move old black boxes from {folder / 'log'} elsewhere")
    else:
        yield ok("disk", says)


def _remedy(error: OSError, folder: Path) -> str:
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"move old black boxes from {folder / 'log'} to another computer, now"
    if error.errno in (errno.EROFS, errno.EIO):
        return "the SD card is failing or was not unmounted: check it with fsck, or replace it"
    return f"chown or chmod {folder} for the user of serve, or name another by `folder:`"


def _next_start(under_way: str, vehicle: Vehicle) -> str:
    """What serve will do about it at its next start."""
    if vehicle.drives:
        return "serve will stop the vehicle when it starts; `auvmission clear` ends that"
    if under_way in STOPS:
        return "serve will stop the vehicle when it starts, and bring it up if it stays deep"
    return (
        "serve will surface the vehicle when it starts; `auvmission clear` at the surface ends that"
    )


def _store(context: CheckContext) -> Iterator[Finding]:
    running = context.running
    if running is not None:
        digest = str(running["mission"])[:16]
        yield ok("mission", f"digest {digest} is stored" if digest else "none is stored")
        return
    try:
        content = DiskStore(context.configuration.store).content
    except StoreError as error:
        yield fault("store", str(error), "mend the folder's owner and rights")
        return
    for damage in content.damage:
        yield warning("store", damage, "upload the mission again, set @SP again")
    if content.under_way:
        yield warning(
            "store",
            f"{content.under_way} was under way when serve ended",
            _next_start(content.under_way, context.vehicle),
        )
    yield ok(
        "mission", f"{len(content.lines)} lines are stored" if content.lines else "none is stored"
    )


def _clock(context: CheckContext) -> Iterator[Finding]:
    now = datetime.now(UTC)
    if now.year not in YEARS:
        yield fault(
            "clock",
            f"the system's clock says {now:%Y-%m-%d}",
            "set it (sudo date -u -s ...), or send @ST with set_system_clock: true",
        )
    else:
        yield ok("clock", f"{now:%Y-%m-%d %H:%M:%S} UTC: compare with your watch")
    first = time.monotonic()
    time.sleep(0.01)
    if not 0.005 < time.monotonic() - first < 1.0:
        yield fault(
            "clock monotonic", "does not run evenly", "restart the Pi; replace it if it stays"
        )


def _crc(context: CheckContext) -> Iterator[Finding]:
    from crcmod.crcmod import _usingExtension

    if _usingExtension:
        yield ok("CRC", "crcmod's C extension is there")
    else:
        yield warning(
            "CRC",
            "crcmod runs in pure Python, 40 times slower",
            "apt install gcc python3-dev, then pip install --force-reinstall crcmod",
        )


def build_of(context: CheckContext) -> Iterator[Finding]:
    yield ok("build", f"auvmission {__version__}, {build()}")


def _topside(context: CheckContext) -> Iterator[Finding]:
    url = context.configuration.links.topside
    try:
        address = parse_address(listening(url))
    except LinkError as error:
        yield fault("topside", str(error), "mend links.topside of the configuration")
        return
    tls = address.scheme == "tls-listen"
    keys = _keys(Path(address.options.get("keys") or _default_keys()).expanduser()) if tls else None
    port = ok("topside", "")
    if context.running is None and context.mute is None:
        port = port_probe.port_finding("topside", listening(url))
    if keys is not None and keys.condition is Condition.FAULT:
        yield keys
    elif port.condition is not Condition.OK:
        yield port
    elif open_to_all(url):
        yield warning(
            "topside",
            f"whoever reaches {url} can command the vehicle",
            "listen with tls-listen:// (auvmission keys), or add ?allow=ADDRESSES",
        )
    else:
        yield keys or ok("topside", f"{url}: loopback or allowed addresses only")


def _default_keys() -> str:
    from links.tls import FOLDER

    return FOLDER


def _keys(folder: Path) -> Finding:
    from links.tls import context

    try:
        context(folder, server=True)
    except LinkError as error:
        return fault("topside", str(error), "auvmission keys FOLDER, then copy FOLDER/vehicle here")
    if (folder / "key.pem").stat().st_mode & 0o077:
        says = f"{folder / 'key.pem'} can be read by others: whoever has it is the vehicle"
        return warning("topside", says, f"chmod 600 {folder / 'key.pem'}")
    return ok("topside", f"TLS with the keys in {folder}")


def _ports(context: CheckContext) -> Iterator[Finding]:
    links = context.configuration.links
    if context.running is not None or context.mute is not None:
        yield from _not_asked(context)
    if context.running is not None:
        yield from _of_running(context, context.running)
        return
    if context.mute is not None:
        return  # the mute serve has the ports
    yield from port_probe.vehicle_findings(links.vehicle, context.vehicle)
    if context.ask:
        yield asking.dialect_finding(links.vehicle, context.vehicle)
    if context.move:
        yield from signs.sign_findings(links.vehicle, context.vehicle)
    if links.gps is None:
        yield _without_gps(context.vehicle)
    else:
        yield from port_probe.gps_findings(links.gps)
    if links.gps2 is not None:
        yield from port_probe.gps_findings(links.gps2, "gps2")
    if links.modem is not None:
        yield port_probe.port_finding("modem port", links.modem)
    if links.sensors is not None:
        yield from port_probe.sensors_findings(links.sensors)


def _not_asked(context: CheckContext) -> Iterator[Finding]:
    """Findings for ``ask`` and ``move`` that a running serve or the vehicle rules out."""
    todo = "stop serve (systemctl stop auvmission), then ask again"
    for asked, rows in ((context.ask, asking), (context.move, signs)):
        if asked:
            yield rows.needless(context.vehicle) or fault(
                rows.WHAT, "not asked: a serve has the vehicle's port", todo
            )


def _without_gps(vehicle: Vehicle) -> Finding:
    if "position" in vehicle.reports:
        return ok("GPS", f"none is configured; {board(vehicle).name} tells the place")
    return warning("GPS", "none is configured", "every mission must say `start without fix`")


def _camera(context: CheckContext) -> Iterator[Finding]:
    command = context.configuration.camera
    if command is None:
        return
    try:
        program = shlex.split(command)[0]
    except (ValueError, IndexError) as error:
        yield fault("camera", f"{command}: {error}", "mend `camera:` of the configuration")
        return
    if shutil.which(program) is None:
        yield fault("camera", f"there is no program {program}", "install it, or mend `camera:`")
    else:
        yield ok("camera", f"{shutil.which(program)}; `@NS` opens and closes it")


def _of_silent(link: str, vehicle: Vehicle) -> str:
    quiet = board(vehicle).quiet if link == "vehicle" else ""
    return "check its power and cable" + (f"; {quiet}" if quiet else "")


def _of_running(context: CheckContext, running: Mapping[str, Any]) -> Iterator[Finding]:
    for name, link in running["links"].items():
        if not link["open"]:
            yield fault(
                f"link {name}",
                f"{link['url']} is not open",
                "the journal of serve says why; a node that @NS has closed, @NS opens",
            )
        elif _silent(link) > (longest := _longest(name, context)):
            yield fault(
                f"link {name}",
                f"nothing from {link['url']} for {longest:g} s",
                _of_silent(name, context.vehicle),
            )
        else:
            says = f"{link['received']} bytes in, {link['sent']} out, {link['faults']} faults"
            yield ok(f"link {name}", says)
    for name, sensor in running["sensors"].items():
        if sensor["why"] not in ("", "absent") and name not in ("leak", "range", "uncertainty"):
            yield warning(
                f"sensor {name}", sensor["why"], f"check it before the {trip(context.vehicle)}"
            )
    for name, margin in running["margins"].items():
        unit = margin["unit"]
        left = "not known now" if margin["left"] is None else f"{margin['left']:.1f} {unit} left"
        yield ok(f"margin {name}", f"{left}, limit {margin['bound']:g} {unit}")
    for name in running["breached"]:
        yield fault(f"limit {name}", "is breached now", "see auvmission status --local")
    if running["black_box_failure"]:
        yield fault("black box", running["black_box_failure"], "free the disk, restart serve")


def _longest(link: str, context: CheckContext) -> float:
    """How long the link may be silent, s."""
    talks = link != "vehicle" or board(context.vehicle).reports
    return _SILENT.get(link, math.inf) if talks else math.inf


def _silent(link: Mapping[str, Any]) -> float:
    return math.inf if link["silent_s"] is None else float(link["silent_s"])


def _limits(context: CheckContext) -> Iterator[Finding]:
    """The tightest of three limits is in force; the mission's own limits are not known here."""
    vehicle = context.vehicle
    if context.running is None:
        try:
            operator = DiskStore(context.configuration.store).content.limits
        except StoreError:
            return
        bounds = in_force(vehicle, None, operator)
        depth = "" if vehicle.drives else f"depth {bounds.depth:g} m, "
        yield ok(
            "limits",
            f"without a mission's own: radius {bounds.radius:g} m, {depth}"
            f"time {bounds.time / 60:g} min, voltage {bounds.voltage:g} V",
            "compare with what today's place allows; auvmission limits tightens them",
        )
    yield from never_acting(vehicle)


def _buoyant(context: CheckContext) -> Iterator[Finding]:
    yield from buoyant(context.vehicle)


def _assumed(context: CheckContext) -> Iterator[Finding]:
    yield from assumed(context.vehicle)


ROWS: tuple[Callable[[CheckContext], Iterable[Finding]], ...] = (
    _configured,
    _disk,
    _store,
    _clock,
    _crc,
    build_of,
    _topside,
    _ports,
    _camera,
    _limits,
    _buoyant,
    _assumed,
)
