"""Facts of a dive that no decision records: silences, and what fixes showed.

    Messages --Unsaid--> sentences

What does not live here: decisions and commands (story), the smoothed track (smoothing).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from mission.analysis.resting import SILENT_S, Sunk, Unfixed
from mission.analysis.turned import Turned
from mission.model import Position, Record
from mission.model.shown import clock, duration
from mission.navigation.geodesy import LocalFrame
from mission.onboard.runtime import records as rec
from mission.onboard.stream.derived import Message
from mission.onboard.stream.topics import AID, FIX, STATE, TELEMETRY
from protocol.topside_frames import SENSORS

ALONE_S = 60.0  # without a fix: after that the next one's distance is reported
DEEP_M = 2.0  # deeper, no receiver works
_SWITCHED = re.compile(rb"@RS([OC]{%d})\$" % len(SENSORS))


@dataclass(slots=True)
class _Wet:
    """Fixes from under water."""

    count: int
    first: float
    last: float


class Absence:
    """Times when nobody was connected to an operator's port where somebody had been."""

    def __init__(self) -> None:
        self._there: dict[str, set[str]] = {}
        self._gone: dict[str, list[tuple[float, float]]] = {}  # begin, end; inf while it lasts

    def receive(self, record: Record) -> None:
        if record.kind not in (rec.CONNECTED, rec.DISCONNECTED):
            return
        link, address = rec.read_texts(record)
        there, gone = self._there.setdefault(link, set()), self._gone.setdefault(link, [])
        if record.kind == rec.CONNECTED:
            there.add(address)
            if gone and math.isinf(gone[-1][1]):
                gone[-1] = gone[-1][0], record.t
            return
        if address in there and len(there) == 1:  # a disconnection may be recorded twice
            gone.append((record.t, math.inf))
        there.discard(address)

    def at_last(self, end: float) -> Iterator[str]:
        for link, gone in self._gone.items():
            told = [(begin, min(back, end)) for begin, back in gone]
            told = [(begin, back) for begin, back in told if back - begin > SILENT_S]
            if told:
                lasted = duration(round(sum(back - begin for begin, back in told)))
                often = "" if len(told) == 1 else f"{len(told)} times, "
                when = f"between {clock(told[0][0])} and {clock(told[-1][1])}"
                yield f"Nobody was connected to {link} for {lasted}, {often}{when}."


class Power:
    """The vehicle's devices that operators have switched on or off by ``@RS``."""

    def __init__(self) -> None:
        self._letters = ""

    def sent(self, t: float, data: bytes) -> Iterator[str]:
        found = _SWITCHED.fullmatch(data)
        if found is None or found[1].decode() == self._letters:
            return
        self._letters = found[1].decode()
        pairs = list(zip(SENSORS, self._letters, strict=True))
        on, off = ([name for name, letter in pairs if letter == which] for which in "OC")
        says = (f"{', '.join(names)} {to}" for names, to in ((on, "on"), (off, "off")) if names)
        yield f"{clock(t)}: an operator had power switched: {'; '.join(says)}."


class Unsaid:
    """Facts of one run of the program. ``receiver``: the vehicle reports its position."""

    def __init__(self, receiver: bool = True) -> None:
        self._unfixed, self._sunk = Unfixed() if receiver else None, Sunk()
        self._turned = Turned()
        self._reported: float | None = None
        self._fixed: float | None = None
        self._depth: float | None = None
        self._state: Mapping[str, Any] = {}
        self._wet: _Wet | None = None
        self._added = 0  # values of added sensors
        self.lost = False  # records are missing, so absence proves nothing

    def receive(
        self,
        message: Message,
        origin: Position | None,
        believed: bool = True,
        by_hand: bool = False,
    ) -> Iterator[str]:
        """``origin``: of the estimate's metres; ``believed``: the depth is believed; ``by_hand``:
        the stick drives, and not every board reports then."""
        if message.topic == STATE:
            self._state = message.value
            self._sunk.state(message.t, message.value["state"])
        elif message.topic == TELEMETRY:
            depth = message.value["depth_m"]
            yield from self._report(message.t, depth, by_hand)
            tilt = (message.value.get(f"{name}_deg") for name in ("pitch", "roll"))
            yield from self._turned.report(message.t, *tilt)
            self._sunk.report(depth)
            if self._unfixed is not None:
                yield from self._unfixed.report(message.t, depth, believed)
                if message.value["latitude_deg"] is not None:  # it reports its own position
                    yield from self._unfixed.fix(message.t)
        elif message.topic == AID:
            self._added += 1
        elif message.topic == FIX:
            if self._unfixed is not None:
                yield from self._unfixed.fix(message.t)
            yield from self._fix(message.t, message.value, origin, believed)

    def forget(self) -> None:
        """Start again after missing records: nothing is known about that time."""
        self.lost, self._reported, self._fixed = True, None, None

    def at_last(self, end: float) -> Iterator[str]:
        """Yield the sentences that are known only at the end of the recording."""
        if self._unfixed is not None:
            yield from self._unfixed.at_last(end)
            if self._fixed is not None and end - self._fixed > ALONE_S:
                alone = duration(round(end - self._fixed))
                yield f"The last fix came {clock(self._fixed)}, {alone} before the recording ends."
        yield from self._sunk.at_last()
        yield from self._turned.at_last(end)
        if self._reported is None:
            if not self.lost:
                yield "The vehicle never reported."
        elif end - self._reported > SILENT_S:
            yield (
                f"The vehicle's last report came {clock(self._reported)}, "
                f"{duration(round(end - self._reported))} before the recording ends."
            )
        if self._added:
            yield (
                f"Sensors that were added said {self._added} values; what the estimate made of "
                "them is not told here."
            )
        if self._wet is not None:
            wet = self._wet
            yield (
                f"{wet.count} fixes came from more than {DEEP_M:g} m of depth, from "
                f"{clock(wet.first)} to {clock(wet.last)}: no receiver hears there."
            )

    def _report(self, t: float, depth: float | None, by_hand: bool) -> Iterator[str]:
        before, self._reported, self._depth = self._reported, t, depth
        if before is None and t > SILENT_S and not self.lost:
            yield f"{clock(t)}: the first report of the vehicle; until then it had said nothing."
        if before is not None and t - before > SILENT_S:
            driven = ", which was driven by hand," if by_hand else ""
            silent = duration(round(t - before))
            yield f"{clock(t)}: the first report of the vehicle{driven} in {silent}."

    def _fix(
        self, t: float, fix: Mapping[str, Any], origin: Position | None, believed: bool
    ) -> Iterator[str]:
        if believed and self._depth is not None and self._depth > DEEP_M:
            wet = self._wet or _Wet(0, t, t)
            self._wet = _Wet(wet.count + 1, wet.first, t)
            return
        before, self._fixed = self._fixed, t
        north, east = self._state.get("north_m"), self._state.get("east_m")
        if t - (before or 0.0) < ALONE_S or (before is None and self.lost):
            return
        if before is None or origin is None or north is None or east is None:
            yield f"{clock(t)}: the first fix in {duration(round(t - (before or 0.0)))}."
            return
        place = (math.radians(fix[name]) for name in ("latitude_deg", "longitude_deg"))
        away = math.dist(LocalFrame(origin).to_local(*place), (north, east))
        yield (
            f"{clock(t)}: the first fix in {duration(round(t - before))} lay {away:.0f} m from "
            f"where it took itself to be, 95 % sure within {self._state['radius_95_m']:.0f} m."
        )
