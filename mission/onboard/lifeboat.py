"""The last way to the surface if serve cannot be loaded: one loop, the standard library alone.

    the store says          the lifeboat
    something is under way  tries thrust upward, letting go and W in turn, TURN_S each; it keeps the
                            one that makes the depth fall, and stops at the surface
    at rest, or unknown     sends a stop; it ascends as above after DEEP_REPORTS deep reports
    nothing is under way    does nothing: the error of serve remains

Commands, port and bit rate are those of the last configuration that worked (serve: working), else
the AUV's. The port is serial, TCP, or a CAN bus of Linux (SocketCAN). The lifeboat reads a depth
only from an ``@SD``. It obeys no operator and records nothing: whoever reads the journal has to
repair the program. What does not live here: everything else; the engine flies a proper ascent.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import signal
import socket
import struct
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

from mission.onboard.kept import Homes, default_folder, read_summed
from mission.onboard.serve.watchdog import Watchdog

TURN_S, FALL_M = 10.0, 0.3
AGAIN_S, TIMES = 0.5, 3  # s between repeats, times sent: no answer is awaited
GAP_S = 0.05  # s between two frames: the STM32 misreads frames that come in one burst
DEEP_M, DEEP_REPORTS = 2.0, 3
ABOVE_M, SHALLOW_M, SHALLOW_S = -0.8, 0.5, 6.0
STALE_S = 6.0
REPORT, DEPTH_AT = 86, 19  # bytes of an @SD, offset of its depth
AT_REST = (
    *("emergency/stopped", "emergency/surfaced", "the stick", "a stop without", "rest "),
    "something that the store",
)
_BUFFER = 4096
_STANDARD = 0x7FF  # the highest standard CAN identifier

Way = tuple[bytes, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    """What to send. ``period``: s between repeats for a board that needs them; None: the board
    keeps its last command. ``climbs``: something is under way."""

    url: str = "serial:///dev/serial0"
    baud: int = 9600
    stop: Way = (b"@ZAX0$",)
    surface: Way = (b"@ZAWF$",)
    up: Way = (b"@ZAX0$", b"@ZAU12$")
    period: float | None = None
    climbs: bool = True


class Climb:
    """Decides what to send. The caller gives the times."""

    def __init__(self, plan: Plan, now: float) -> None:
        self._plan, self._climbs = plan, plan.climbs
        self._ways = (plan.up or plan.surface, plan.stop, plan.surface)
        self._turn = 0
        self._start: float | None = None
        self._since, self._due, self._left = now, now, TIMES
        self._depth, self._heard = math.nan, -math.inf
        self._first: float | None = None
        self._moves = False  # a depth that never changes proves no surface
        self._shallow: float | None = None
        self._deep = 0

    @property
    def way(self) -> Way:
        return self._ways[self._turn % len(self._ways)] if self._climbs else self._plan.stop

    @property
    def last_words(self) -> Way:
        """The command to leave in force when the lifeboat ends; () at rest."""
        return self._ways[0] if self._climbs else ()

    def hear(self, depth: float, now: float) -> None:
        silent, self._heard, self._depth = now - self._heard > STALE_S, now, depth
        self._start = depth if self._start is None else self._start
        self._deep = self._deep + 1 if depth > DEEP_M else 0
        if self._climbs and self._at_surface(depth, now, silent):
            self._change(False, now)
        elif not self._climbs and self._deep >= DEEP_REPORTS:
            self._change(True, now)

    def _at_surface(self, depth: float, now: float, silent: bool) -> bool:
        """Whether the depth was shallow for 6 s without a dropout, never 0.8 m or more above the
        water, and has ever changed (R7)."""
        self._first = depth if self._first is None else self._first
        self._moves = self._moves or depth != self._first
        if not ABOVE_M < depth < SHALLOW_M or not self._moves:
            self._shallow = None
        elif self._shallow is None or silent:
            self._shallow = now
        return self._shallow is not None and now - self._shallow >= SHALLOW_S

    def words(self, now: float) -> Way:
        """The frames that are due."""
        if self._climbs and now - self._since >= TURN_S:
            self._take_turns(now)
        if now < self._due or (self._left <= 0 and self._plan.period is None):
            return ()
        self._left -= 1
        self._due = now + (self._plan.period or AGAIN_S)
        return self.way

    def _change(self, climbs: bool, now: float) -> None:
        self._climbs, self._turn, self._start = climbs, 0, self._known(now)
        self._since, self._due, self._left = now, now, TIMES
        self._shallow = None  # a new climb has to prove it again

    def _take_turns(self, now: float) -> None:
        before, depth, self._since = self._start, self._known(now), now
        self._start = depth
        if before is None or depth is None or before - depth < FALL_M:
            self._turn += 1
            self._due, self._left = now, TIMES

    def _known(self, now: float) -> float | None:
        return self._depth if now - self._heard <= STALE_S else None


def depths(buffer: bytearray) -> Iterator[float]:
    """Yield the depth (m) of each whole @SD in the buffer, and remove these reports."""
    while (at := buffer.find(b"@SD")) >= 0 and len(buffer) >= at + REPORT:
        frame = bytes(buffer[at : at + REPORT])
        whole = frame.endswith(b"$")
        del buffer[: at + (REPORT if whole else 1)]
        (depth,) = struct.unpack_from("<f", frame, DEPTH_AT)
        if whole and math.isfinite(depth) and abs(depth) < 1000.0:
            yield depth
    del buffer[:-_BUFFER]


def plan_from(arguments: Sequence[str], environment: Mapping[str, str]) -> Plan | None:
    """The plan from serve's command line and environment; None if nothing is under way."""
    given = {name: _option(arguments, name) for name in ("--config", "-c", "--folder", "--vehicle")}
    config, folder = given["--config"] or given["-c"], given["--folder"]
    homes = Homes(Path(config) if config else None, Path(folder) if folder else None, environment)
    kept = next((found for path in homes.paths() if (found := _json(path))), {})
    plan = _words(kept, given["--vehicle"])
    where = homes.folder or Path(kept.get("configuration", {}).get("folder", default_folder()))
    under_way = _under_way(where / "store", known=bool(kept) or homes.folder is not None)
    if not under_way:
        return None
    return plan if not under_way.startswith(AT_REST) else _at_rest(plan)


def _at_rest(plan: Plan) -> Plan:
    return replace(plan, climbs=False)


def _under_way(store: Path, known: bool) -> str:
    try:
        return read_summed(store / "under-way")
    except FileNotFoundError:
        return "" if known else AT_REST[-1]
    except (OSError, ValueError):
        return AT_REST[-1]


def _words(kept: dict, vehicle: str) -> Plan:  # type: ignore[type-arg]
    usual = Plan()
    url = vehicle or kept.get("configuration", {}).get("links", {}).get("vehicle", "") or usual.url
    baud = _options(url).get("baud", "")
    ways = {name: tuple(map(bytes.fromhex, way)) for name, way in kept.get("ways", {}).items()}
    return Plan(
        url,
        int(baud) if baud.isdigit() else kept.get("baud", usual.baud),
        ways.get("stop", usual.stop),
        ways.get("surface", usual.surface),
        ways.get("up", () if ways else usual.up),
        kept.get("period"),
    )


def _options(url: str) -> dict[str, str]:
    return dict(parse_qsl(url.partition("?")[2]))


def _json(path: Path) -> dict:  # type: ignore[type-arg]
    try:
        found = json.loads(read_summed(path))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _option(arguments: Sequence[str], name: str) -> str:
    for i, argument in enumerate(arguments):
        if argument == name and i + 1 < len(arguments):
            return arguments[i + 1]
        if argument.startswith(f"{name}="):
            return argument.partition("=")[2]
    return ""


# --- with clock and port -------------------------------------------------------------------------


def launch(plan: Plan) -> None:
    """Run until a signal. Raises SystemExit for a kind of port that it cannot open."""
    if _kind(plan.url) not in _OPENS:
        raise SystemExit(
            f"lifeboat: {plan.url}: only serial, tcp and can (socketcan) are open to it"
        )
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: signals.append(received))
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    watchdog, climb, buffer = Watchdog(), Climb(plan, time.monotonic()), bytearray()
    watchdog.ready()
    port = -1
    while not signals:
        watchdog.fed(time.monotonic())
        if port < 0:
            port = opened(plan)
        try:
            _turn(port, plan, climb, buffer)
        except OSError:
            port = _closed(port)
    with contextlib.suppress(OSError):
        _say(port, plan, climb.last_words)


def _turn(port: int, plan: Plan, climb: Climb, buffer: bytearray) -> None:
    """Read what the port has, and send what is due. Raises OSError."""
    if port < 0:
        time.sleep(AGAIN_S)
        return
    if select.select([port], [], [], 0.1)[0]:
        data = os.read(port, 4096)
        if not data:
            raise OSError("the device went away")
        buffer += data
    now = time.monotonic()
    for depth in depths(buffer):
        climb.hear(depth, now)
    _say(port, plan, climb.words(now))


def _say(port: int, plan: Plan, way: Way) -> None:
    for frame in map(can_frame, way) if _kind(plan.url) == "can" else way:
        if frame:
            os.write(port, frame)
            time.sleep(GAP_S)
    if way:
        sys.stderr.write(f"lifeboat: to the vehicle: {b' '.join(way)!r}\n")


def can_frame(record: bytes) -> bytes:
    """Linux's can_frame for a record of links.can; b"" if it is for the line beside the bus."""
    identifier, size, data = int.from_bytes(record[:2], "big"), record[2], record[3:]
    return struct.pack("=IB2xB8s", identifier, size, size, data) if identifier <= _STANDARD else b""


def _kind(url: str) -> str:
    """The URL's scheme; for CAN by another interface than socketcan, that interface."""
    scheme, interface = url.partition("://")[0], _options(url).get("interface", "socketcan")
    return scheme if scheme != "can" or interface == "socketcan" else interface


def opened(plan: Plan) -> int:
    """Open the port; -1 if that fails."""
    try:
        return _OPENS[_kind(plan.url)](plan)
    except (OSError, ValueError):
        return -1


def _open_serial(plan: Plan) -> int:
    import fcntl
    import termios
    import tty

    port = os.open(urlsplit(plan.url).path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        fcntl.flock(port, fcntl.LOCK_EX | fcntl.LOCK_NB)
        tty.setraw(port)
        attributes = termios.tcgetattr(port)
        attributes[4] = attributes[5] = getattr(termios, f"B{plan.baud}", termios.B9600)
        termios.tcsetattr(port, termios.TCSANOW, attributes)
    except (OSError, termios.error):
        return _closed(port)
    return port


def _open_tcp(plan: Plan) -> int:
    there = urlsplit(plan.url)
    link = socket.create_connection((there.hostname or "", there.port or 0), AGAIN_S)
    link.setblocking(False)
    return link.detach()


def _open_bus(plan: Plan) -> int:
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
        bus.setblocking(False)
        bus.bind((urlsplit(plan.url).netloc,))
        return bus.detach()


_OPENS = {"serial": _open_serial, "tcp": _open_tcp, "can": _open_bus}


def _closed(port: int) -> int:
    with contextlib.suppress(OSError):
        os.close(port)
    return -1
