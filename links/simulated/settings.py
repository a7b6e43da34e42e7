"""The settings of a simulated flight: parses ``--set KEY=VALUE`` texts into a ``Settings``.

    SettingError      (the user must act; it names the text, what to write, and the known keys)

    current=0.3@45        m/s towards 45 deg          deep_current=0.1@200   the same at the floor
    thermocline=4@12      deg C colder below 12 m
    floor=25              m                           declination=-6.1       deg, east positive
    compass_bias=4        deg                         buoyancy=15            N, net
    fault=depth_frozen@120+60                         a row of FAULTS from 120 s for 60 s
    fault=left_main_weak=0.3@200+100                  the same with a value

What does not live here: what a fault does (faults.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from math import inf, isfinite, radians

from links.simulated.added import LIES, Fitted, SimulatedBeacon
from links.simulated.added_faults import SECOND
from links.simulated.board_faults import OF_BOARDS
from links.simulated.faults import FAULTS
from links.simulated.plant import Body
from links.simulated.sea import Sea
from links.simulated.sensors import SensorErrors


class SettingError(ValueError):
    pass


@dataclass(frozen=True, slots=True)
class FaultEvent:
    name: str
    begin: float  # s
    duration: float | None = None  # s; None: the default of the row
    value: float | None = None  # None: the default of the row


@dataclass(frozen=True, slots=True)
class Settings:
    sea: Sea = field(default_factory=Sea)
    errors: SensorErrors = field(default_factory=SensorErrors)
    body: Body = field(default_factory=Body)
    faults: tuple[FaultEvent, ...] = ()
    splice: float | None = None  # probability; None: the default of the profile
    added: Fitted = field(default_factory=Fitted)
    second_gps: float | None = None  # m: noise of a second receiver; None: not fitted
    sentences: tuple[str, ...] = ("GGA", "RMC")  # of the GPS receiver, every second
    uneven: float = 0.0  # s that an @SD may be early or late
    answers_late: float = 0.0  # s, greatest delay of the STM32's answers
    thrust: float = 1.0  # factor on the thrust of the body's main thrusters

    def pushed(self, body: Body) -> Body:
        """``body`` with the thrust of these settings."""
        return replace(body, main_thrust=self.thrust * body.main_thrust)

    def has(self, part: str) -> bool:
        """Whether the part that a fault ``needs`` is fitted; True for ""."""
        if part == SECOND:
            return self.second_gps is not None
        return not part or self.added.has(part)


Apply = Callable[[Settings, str], Settings]


@dataclass(frozen=True, slots=True)
class Setting:
    """One row: the form of its value, its description, and how it is applied."""

    form: str
    says: str
    apply: Apply


def _number(text: str, low: float = -inf, high: float = inf) -> float:
    try:
        value = float(text)
    except ValueError:
        raise SettingError(f"{text!r} is not a number") from None
    if not isfinite(value):
        raise SettingError(f"{text} is not a finite number")
    if not low <= value <= high:
        raise SettingError(f"{text} is not between {low:g} and {high:g}")
    return value


def _current(text: str) -> tuple[float, float]:
    speed, at, direction = text.partition("@")
    if not at:
        raise SettingError(f"write speed@direction, e.g. 0.3@45, not {text!r}")
    return _number(speed, 0.0, 5.0), radians(_number(direction, -360.0, 360.0))


def _waves(text: str) -> tuple[float, float]:
    amplitude, at, period = text.partition("@")
    if not at:
        raise SettingError(f"write amplitude@period, e.g. 0.4@6, not {text!r}")
    return _number(amplitude, 0.0, 5.0), _number(period, 2.0, 20.0)


def _sea(name: str, read: Callable[[str], object]) -> Apply:
    return lambda s, text: replace(s, sea=replace(s.sea, **{name: read(text)}))  # type: ignore[arg-type]


def _errors(name: str, scale: float, low: float = 0.0, high: float = inf) -> Apply:
    def apply(settings: Settings, text: str) -> Settings:
        value = scale * _number(text, low, high)
        changed: SensorErrors = replace(settings.errors, **{name: value})  # type: ignore[arg-type]
        return replace(settings, errors=changed)

    return apply


def _layer(name: str) -> Apply:
    def apply(settings: Settings, text: str) -> Settings:
        degrees, at, depth = text.partition("@")
        if not at:
            raise SettingError(f"write degrees@depth, e.g. 4@12, not {text!r}")
        layer = _number(degrees, -30.0, 30.0), _number(depth, 0.0, 11000.0)
        changed: SensorErrors = replace(settings.errors, **{name: layer})  # type: ignore[arg-type]
        return replace(settings, errors=changed)

    return apply


def _fitted(name: str, *, binary: bool = False) -> Apply:
    def apply(settings: Settings, text: str) -> Settings:
        sigma = _number(text, 0.0, 100.0)
        said: Fitted = replace(settings.added, **{name: sigma})  # type: ignore[arg-type]
        return replace(settings, added=replace(said, binary=binary or said.binary))

    return apply


def _beacon(settings: Settings, text: str) -> Settings:
    number, at, place = text.partition("@")
    parts = place.split(",")
    if not at or len(parts) != 3 or not number.isdecimal() or int(number) > 127:
        raise SettingError(
            f"write number@latitude,longitude,depth, 3@30.288,120.154,4, not {text!r}"
        )
    latitude, longitude = _number(parts[0], -90.0, 90.0), _number(parts[1], -180.0, 180.0)
    depth = _number(parts[2], 0.0, 11000.0)
    beacon = SimulatedBeacon(int(number), radians(latitude), radians(longitude), depth)
    added = replace(settings.added, beacons=(*settings.added.beacons, beacon))
    return replace(settings, added=added)


def _second(settings: Settings, text: str) -> Settings:
    return replace(settings, second_gps=_number(text, 0.0, 100.0))


def _lie(settings: Settings, text: str) -> Settings:
    lie, at, begin = text.partition("@")
    if not at or lie not in LIES:
        raise SettingError(f"write one of {', '.join(LIES)} and its time, e.g. frozen@100")
    added = replace(settings.added, lie=lie, lies_from=_number(begin, 0.0))
    return replace(settings, added=added)


def _buoyancy(settings: Settings, text: str) -> Settings:
    return replace(settings, body=replace(settings.body, buoyancy=_number(text, -50.0, 100.0)))


def _thrust(settings: Settings, text: str) -> Settings:
    return replace(settings, thrust=_number(text, 0.0, 4.0))


def _splice(settings: Settings, text: str) -> Settings:
    return replace(settings, splice=_number(text, 0.0, 1.0))


def _uneven(settings: Settings, text: str) -> Settings:
    return replace(settings, uneven=_number(text, 0.0, 1.8))


def _answers(settings: Settings, text: str) -> Settings:
    return replace(settings, answers_late=_number(text, 0.0, 2.0))


def parse_fault(text: str) -> FaultEvent:
    """``name[=value]@begin[+duration]``."""
    what, at, when = text.rpartition("@")
    name, equals, value = what.partition("=")
    if not at:
        raise SettingError(f"write name@begin+duration, e.g. depth_frozen@120+60, not {text!r}")
    known = dict.fromkeys(name for rows in (FAULTS, *OF_BOARDS.values()) for name in rows)
    if name not in known:
        raise SettingError(f"no fault {name!r}; known: {', '.join(known)}")
    begin, plus, duration = when.partition("+")
    return FaultEvent(
        name,
        _number(begin, 0.0),
        _number(duration, 0.0) if plus else None,
        _number(value) if equals else None,
    )


def _fault(settings: Settings, text: str) -> Settings:
    return replace(settings, faults=(*settings.faults, parse_fault(text)))


_DEG = radians(1.0)

SETTINGS: dict[str, Setting] = {
    "current": Setting("SPEED@DIRECTION", "m/s towards deg", _sea("current", _current)),
    "deep_current": Setting(
        "SPEED@DIRECTION", "the current at the floor", _sea("deep_current", _current)
    ),
    "waves": Setting("M@S", "amplitude and period; a robot feels none", _sea("waves", _waves)),
    "floor": Setting("DEPTH", "m", _sea("floor", lambda text: _number(text, 1.0, 11000.0))),
    "declination": Setting("DEG", "east positive", _errors("declination", _DEG, -180.0, 180.0)),
    "compass_bias": Setting("DEG", "", _errors("compass_bias", _DEG, -180.0, 180.0)),
    "compass_noise": Setting("DEG", "one sigma", _errors("compass_noise", _DEG)),
    "compass_slow": Setting("DEG", "one sigma, 300 s", _errors("compass_slow", _DEG)),
    "deviation": Setting("DEG", "amplitude over the heading", _errors("deviation", _DEG)),
    "depth_bias": Setting("M", "", _errors("depth_bias", 1.0, -100.0)),
    "depth_noise": Setting("M", "one sigma", _errors("depth_noise", 1.0)),
    "altitude_range": Setting("M", "no echo beyond", _errors("altitude_range", 1.0)),
    "altitude_drop": Setting("SHARE", "without an echo", _errors("altitude_drop", 1.0, 0.0, 1.0)),
    "thermocline": Setting("DEG@DEPTH", "C colder below that depth (m)", _layer("thermocline")),
    "warm_layer": Setting("DEG@DEPTH", "C warmer at that depth (m)", _layer("warm_layer")),
    "fix_noise": Setting("M", "one sigma per axis", _errors("fix_noise", 1.0)),
    "fix_wander": Setting("M", "the same, of what stays for 100 s", _errors("fix_wander", 1.0)),
    "fix_settle": Setting("M", "the same, of the first behind a dive", _errors("fix_settle", 1.0)),
    "speed_log": Setting("M/S", "sigma; an added speed log", _fitted("speed_log")),
    "doppler": Setting("M/S", "sigma; an added Doppler log", _fitted("doppler")),
    "acoustic": Setting("M", "sigma; an added acoustic position, every 5 s", _fitted("acoustic")),
    "doppler_pd0": Setting(
        "M/S", "sigma; the same Doppler log, binary", _fitted("doppler", binary=True)
    ),
    "ranges": Setting("M", "sigma; ranges to beacons, one every 5 s", _fitted("ranges")),
    "beacon": Setting("NUMBER@LAT,LON,DEPTH", "where one truly is; may be given again", _beacon),
    "second_gps": Setting("M", "sigma; a second GPS receiver", _second),
    "added_lie": Setting("HOW@BEGIN", f"added sensors: {', '.join(LIES)}", _lie),
    "first_fix": Setting("S", "after power-on", _errors("first_fix", 1.0)),
    "buoyancy": Setting("N", "net, upward", _buoyancy),
    "thrust": Setting("SHARE", "of what the main thrusters have; a robot's wheels alike", _thrust),
    "uneven": Setting("S", "that an @SD comes early or late, to 0.2 s; boards none", _uneven),
    "answers_late": Setting("S", "of an STM32, at most, each as drawn; boards give none", _answers),
    "splice": Setting("CHANCE", "of an answer inside an @SD", _splice),
    "fault": Setting("NAME[=VALUE]@BEGIN[+DURATION]", "s; may be given again", _fault),
}


def parse_settings(texts: Iterable[str], settings: Settings | None = None) -> Settings:
    """Apply texts to settings. Raises SettingError: the wrong text, and what to write instead."""
    result = settings or Settings()
    for text in texts:
        key, equals, value = text.partition("=")
        row = SETTINGS.get(key.strip())
        if row is None or not equals:
            known = "\n".join(f"  {name}={row.form}  {row.says}" for name, row in SETTINGS.items())
            raise SettingError(f"cannot set {text!r}; write KEY=VALUE with one of\n{known}")
        try:
            result = row.apply(result, value.strip())
        except SettingError as error:
            raise SettingError(f"{text}: {error}") from None
    return result


def setting_of(event: FaultEvent) -> str:
    """The text that gives this event, to fly a failing flight again."""
    value = "" if event.value is None else f"={event.value!r}"
    duration = "" if event.duration is None else f"+{event.duration!r}"
    return f"{event.name}{value}@{event.begin!r}{duration}"
