"""Whether each sensor can be believed: missing, stale, frozen, absurd or contradicted, else valid.

    missing  never reported (or the vehicle file says that it is not there)
    stale    the last report is older than the row's max age, or than the vehicle file's
             ``stale_after``
    frozen   identical to the last bit for 5 reports and 7 s while the vehicle moves (some rows
             only: batteries and temperature may well be constant); so is a receiver that sends
             only places which it has sent before, under water too
    absurd   not finite (the codec gives None and a fault), out of the physical range, faster than
             the row's rate, or marked doubtful by the codec. A value that changed too fast is
             believed again once three reports in a row, over a second at least, agree with each
             other: the sensor has come back at another value (a depth is then contradicted). If
             more than every third report is absurd, none is believed until three in a row agree
             (in a row without a rate: until three in a row are not absurd).
    contradicted  the depth alone, by other evidence (belief)

Each row is a channel. A sensor has one or more channels, and is as good as the worst of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from dataclasses import dataclass
from types import MappingProxyType

from mission.model import Health, Vertical
from mission.model.vehicle import STALE_AFTER
from mission.navigation.belief import UNPUSHED, DepthBelief
from mission.navigation.fixes import FIX_DEPTH, Receiver
from protocol.messages import Fix, Telemetry

_SAME = 5  # identical reports that make a sensor frozen (design: readings are three-valued)
_MOSTLY, _WORST = 3, 6  # score of bad reports: from here on none is believed; the greatest
_STANDS = 7.0  # s of them: a board may send 50 times a second what its sensor measures twice
_AGREE, _AGREE_FOR = 3, 1.0  # reports, and s, that agree and overrule the rate limit
_BACK, _GOES_ON = 5.0, 0.25  # s, share of the rate: a return so soon and so near is no leap
_NEUTRAL = 0.02  # thruster fraction below which nothing moves
_SLOW, _GPS = 30.0, 5.0  # s, max age: of slow quantities; of a fix (R9)


@dataclass(frozen=True, slots=True)
class Channel:
    """``rate`` is the greatest believable change per second; ``wraps`` marks a full circle."""

    sensor: str
    max_age: float
    low: float = -math.inf
    high: float = math.inf
    rate: float = math.inf
    stands: float = math.inf  # s of identical values, after which it is frozen
    wraps: bool = False
    sparse: bool = False  # it often reports an absurd value to say that it measured nothing


# fmt: off
CHANNELS: Mapping[str, Channel] = MappingProxyType({
    "depth": Channel("depth", STALE_AFTER, -3.0, 1000.0, 2.0, stands=_STANDS),
    "altitude": Channel("altitude", STALE_AFTER, 1e-6, 300.0, 15.0, stands=_STANDS,
                        sparse=True),  # 0: no echo
    "heading": Channel("heading", STALE_AFTER, 0.0, 2.0 * math.pi, 1.6, stands=_STANDS, wraps=True),
    "pitch": Channel("attitude", STALE_AFTER, -1.6, 1.6, 1.6, stands=_STANDS),
    "roll": Channel("attitude", STALE_AFTER, -3.2, 3.2, 3.2, stands=_STANDS, wraps=True),
    "temperature": Channel("temperature", _SLOW, -5.0, 60.0),
    "battery": Channel("battery", _SLOW, 0.0, 1000.0),
    "leak": Channel("leak", STALE_AFTER),
    "position": Channel("position", _GPS, stands=0.0),
})
# fmt: on
_IN_TELEMETRY = tuple(name for name in CHANNELS if name != "position")
SENSORS = tuple(dict.fromkeys(row.sensor for row in CHANNELS.values()))
_CHANNELS_OF = {
    sensor: tuple(name for name, row in CHANNELS.items() if row.sensor == sensor)
    for sensor in SENSORS
}


@dataclass(slots=True)
class _Monitor:
    """What is remembered of one channel."""

    t: float = -math.inf  # of the last report
    value: float = math.nan
    good_t: float = -math.inf  # of the last value that was believed
    good: float = math.nan
    was: float = math.nan  # the last other value that was believed before that one, ...
    was_t: float = -math.inf  # ... and when
    same: int = 0  # repeats while moving, and ...
    stood: float = 0.0  # ... s of them
    repeated: bool = False  # the last report said the same as the one before
    agreeing: int = 0
    agreed: float = -math.inf  # since when they agree
    jumped: float = 0.0  # by how much the value jumped when they began to agree
    bad: int = 0  # score: 2 more for an absurd report, 1 less for another
    leapt: float = 0.0  # by how much the value had jumped that the last report made believed
    reason: str = ""

    def observe(self, row: Channel, t: float, value: float, moving: bool, doubt: bool) -> bool:
        """Take one report; return whether it is believed."""
        before = self.value
        self.repeated = again = value == before
        self.same = self.same + moving if again else 0
        self.stood = self.stood + moving * (t - self.t) if again else 0.0
        self.leapt = 0.0
        sound = not doubt and row.low <= value <= row.high  # false for NaN, too
        near = row.rate == math.inf
        if near:
            self.agreeing = self.agreeing + 1 if sound else 0
        else:
            near = goes_on = _near(row, t - self.t, value, before)
            self.agreeing = self.agreeing + 1 if goes_on else 1
            if self.good_t != self.t or self.good != before:  # the last one was not believed
                near = _near(row, t - self.good_t, value, self.good)
            if not goes_on:
                leaps = not near and math.isfinite(value) and not self._returns(row, t, value)
                self.jumped = value - self.good if leaps else 0.0
            elif self.jumped:  # in reach of the old value, but nearer to the new one: not near
                near = near and _apart(row, value, self.good) <= _apart(row, value, before)
        if self.agreeing <= 1:
            self.agreed = t
        self.t, self.value = t, value
        if not sound:
            self._is_absurd(row)
        elif self.same >= _SAME - 1 and self.stood >= row.stands:
            self.reason = "frozen"
        elif self._is_plausible(near):
            self.leapt = 0.0 if near else self.jumped
            if value != self.good:
                self.was, self.was_t = self.good, self.good_t
            self.reason, self.good_t, self.good, self.jumped = "", t, value, 0.0
            return True
        else:
            self._is_absurd(row)
        return False

    def _returns(self, row: Channel, t: float, value: float) -> bool:
        """Whether the value follows the one before that which is believed: that one was wrong."""
        since = t - self.was_t
        within = _GOES_ON * row.rate * max(since, 1.0)
        return since <= _BACK and _apart(row, value, self.was) <= within

    def _is_absurd(self, row: Channel) -> None:
        self.reason = "absurd"
        if not row.sparse:
            self.bad = min(self.bad + 2, _WORST)

    def _is_plausible(self, near: bool) -> bool:
        """Whether it is near the last believed value of a good channel, or enough reports agree."""
        if self.agreeing >= _AGREE and (near or self.t - self.agreed >= _AGREE_FOR):
            self.bad = 0
            return True
        self.bad = max(self.bad - near, 0)
        return near and self.bad < _MOSTLY


def _near(row: Channel, since: float, value: float, other: float) -> bool:
    """Whether ``value`` can follow ``other`` within ``since`` seconds."""
    return other != other or _apart(row, value, other) <= row.rate * max(since, 1.0)


def _apart(row: Channel, a: float, b: float) -> float:
    """The difference of two values of a channel; NaN if one of them is NaN."""
    return abs(math.remainder(a - b, 2.0 * math.pi)) if row.wraps else abs(a - b)


class SensorHealth:
    """One monitor per channel. ``reports``: the sensors that the vehicle file declares;
    ``stale_after``: its greatest age of a believed report, s."""

    def __init__(self, reports: frozenset[str], stale_after: float = STALE_AFTER) -> None:
        self._max_age = {
            name: stale_after if row.max_age == STALE_AFTER else row.max_age
            for name, row in CHANNELS.items()
        }
        self._rows = tuple(
            (name, CHANNELS[name] if CHANNELS[name].sensor in reports else None)
            for name in _IN_TELEMETRY
        )
        self.monitors = {name: _Monitor() for name in CHANNELS}
        self.moving = False  # by the last report
        self.receiver = Receiver()
        self.own = Receiver()  # the position that the vehicle computes itself, judged the same way
        self.belief = DepthBelief()

    def telemetry(self, t: Telemetry, push: Vertical = UNPUSHED) -> frozenset[str]:
        """Take a report; return those of its channels that are believed."""
        moving = t.actuators is None or max(map(abs, t.actuators[:5]), default=0.0) > _NEUTRAL
        self.moving = moving
        doubtful = doubted(t)
        good = []
        battery = t.batteries[0] if t.batteries else None
        leak = None if t.leak is None else float(t.leak)
        values = (t.depth, t.altitude, t.heading, t.pitch, t.roll, t.temperature_c, battery, leak)
        for (name, row), value in zip(self._rows, values, strict=True):
            if row is None:
                continue
            monitor = self.monitors[name]
            if value is None:
                if name in doubtful:
                    monitor.reason = "absurd"
                continue
            if monitor.observe(row, t.t, value, moving, name in doubtful):
                good.append(name)
        if t.depth is not None and self._rows[0][1] is not None:
            self._compare(t, t.depth, push)
            if self.belief.reason and "depth" in good:
                good.remove("depth")
        return frozenset(good)

    def _compare(self, t: Telemetry, depth: float, push: Vertical) -> None:
        """Compare the depth with other evidence. An absurd or frozen depth is left out: it would
        count against the sensor after that has recovered."""
        monitor, altimeter = self.monitors["depth"], self.monitors["altitude"]
        if monitor.reason:
            return
        if monitor.leapt:
            self.belief.leap(t.t, monitor.leapt)
        heard = altimeter.t == t.t and not altimeter.reason and not altimeter.repeated
        mains = max(map(abs, (t.actuators or ())[:2]), default=0.0)
        height = t.altitude if heard else None
        self.belief.take(t.t, depth, height, mains, push, self.receiver)

    def fix(self, f: Fix) -> bool:
        """Take a fix; return whether it is believed. The channel's value is a number that changes
        with each new place."""
        monitor = self.monitors["position"]
        own = f.accuracy == math.inf
        receiver = self.own if own else self.receiver
        receiver.take(f)
        known = 0.0 if math.isnan(monitor.value) else monitor.value
        value = known + 1.0 if receiver.fresh else known
        good = monitor.observe(CHANNELS["position"], f.t, value, self.moving, False)
        return good and not receiver.stale and (own or not self._under_water(f.t))

    def receives(self, now: float) -> bool:
        """Whether the receiver has lately sent a new place, and not under water."""
        return now - self.receiver.news_at <= _GPS and not self._under_water(now)

    def _under_water(self, now: float) -> bool:
        """Whether a believed depth is under water: a receiver makes up any place that it sends
        there."""
        return self.monitors["depth"].good >= FIX_DEPTH and self.of("depth", now).valid

    def afloat(self, now: float) -> bool:
        """Whether a believed depth is at the surface."""
        return self.monitors["depth"].good < FIX_DEPTH and self.of("depth", now).valid

    def forget(self, channel: str) -> None:
        self.monitors[channel] = _Monitor()

    def repeated(self, channel: str) -> bool:
        """Whether the last report repeats a value: an altimeter does so without an echo."""
        return self.monitors[channel].repeated

    def of(self, sensor: str, now: float) -> Health:
        """Return the health of the sensor's worst channel. Raises KeyError for a name that is not
        in SENSORS."""
        names = _CHANNELS_OF.get(sensor)
        if names is None:
            raise KeyError(f"no sensor {sensor}; there are {', '.join(SENSORS)}")
        for name in names:
            monitor = self.monitors[name]
            age, reason = now - monitor.t, monitor.reason
            if age > self._max_age[name]:
                reason = "missing" if age == math.inf else "stale"
            if reason:
                return Health(False, reason, age)
        if sensor == "depth" and self.belief.reason:
            return Health(False, self.belief.reason, age, self.belief.follows)
        return Health(True, "", now - self.monitors[names[0]].t)


_NONE: frozenset[str] = frozenset()
_CONFIRMED = ""  # no channel: an unknown leak code counts as a leak (R16), and is not doubted
_NAMED = {"yaw": "heading", "ez": "heading", "ey": "pitch", "ex": "roll", "leak": _CONFIRMED}


def doubted(report: Telemetry) -> Set[str]:
    """Return the channels that the codec has marked doubtful."""
    return {_channel_of(fault) for fault in report.faults} if report.faults else _NONE


def _channel_of(fault: str) -> str:
    """``yaw_deg:range`` doubts the heading; codecs name fields as their documents do."""
    name = fault.partition(":")[0].rpartition("_")[0] or fault.partition(":")[0]
    return _NAMED.get(name, name)
