"""Recordings of real vehicles as CSV, turned into the bytes that this vehicle would have sent.

    runs      t, lat, lon, depth, roll_deg, pitch_deg, heading_deg, ...   truth in every row
    gliders   unix_s, depth_m, heading_mag_deg, pitch_deg, roll_deg, ..., gps_lat, gps_lon
              truth at the surface only, where there was a fix

Rows become @SD frames every 2 s (or at the rate of the rows, if that is lower). A fix becomes GGA +
RMC without speed and course. Both pass through the decoders that the vehicle uses.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mission.model import Position
from mission.navigation.geodesy import EARTH, LocalFrame
from protocol.messages import Fix, Telemetry
from protocol.nmea import NmeaDecoder, encode_gga, encode_rmc
from protocol.vehicles.auv import ACTUATORS, MAGNETOMETERS, SD, AuvCodec

Array = NDArray[np.float64]

_RUN = ("t", "lat", "lon", "depth", "roll_deg", "pitch_deg", "heading_deg")
_GLIDER = ("unix_s", "depth_m", "heading_mag_deg", "pitch_deg", "roll_deg", "gps_lat", "gps_lon")
_EXTRA = ("altitude_m", "veh_temp_c", "speed_est_mps")
_EVERY = 2.0  # s between two @SD
_SELDOM = 10.0  # s: a heading is valid no longer than that, however rarely it is reported
_SURFACE = 0.5  # m: shallower, the antenna is out of the water
SHORTEST, NEAREST = 30.0, 20.0  # s and m: the least of a run that can be scored
_FASTEST, _BESIDE = 10.0, 20.0  # m/s, m: a place farther from a track is not part of it
UNUSABLE = "without numbers, out of range, of order or of the track"
ADRIFT = "at the surface or not under way: what drove it there is not known, cut off"
_SLOW, _WINDOW = 0.4, 10.0  # of the median speed; s to each side, for the mean speed
_TRACKS = 8  # the newest tracks, to which a place may be added
_UNDATED = datetime(2024, 1, 1, tzinfo=UTC)  # runs have no date, their times begin at 0
CRUISE_PWM, NEUTRAL_PWM = 1500 + round(500 * 8 / 12), 1500  # gear 8; thrusters off


class RecordingError(ValueError):
    """The file is not a recording; the message says what is missing."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording as columns, one value per row; angles in rad, NaN where nothing was recorded.

    ``north`` and ``east`` are m from the first fix; a glider has them only in rows with a fix.
    """

    name: str
    glider: bool
    start: datetime
    origin: Position
    t: Array  # s from the first row
    north: Array
    east: Array
    depth: Array
    heading: Array
    pitch: Array
    roll: Array
    altitude: Array
    temperature: Array
    own_speed: Array  # the vehicle's own estimate, m/s
    places: frozenset[tuple[int, int]] = frozenset()  # 1e-7 deg
    skipped: int = 0  # rows that could not be used
    adrift: int = 0  # rows cut off: at the surface, or not under way

    def rows(self, begin: int, end: int) -> Recording:
        """Return these rows only; times and positions keep their origins."""
        columns = {f.name: getattr(self, f.name) for f in fields(self)}
        arrays: dict[str, Any] = {
            n: v[begin:end] for n, v in columns.items() if isinstance(v, np.ndarray)
        }
        return replace(self, **arrays)

    def overlaps(self, other: Recording) -> bool:
        """Whether both were cut from one recording: more than a tenth of the places of the shorter
        one are also in the other."""
        fewer = min(len(self.places), len(other.places))
        return 10 * len(self.places & other.places) > fewer

    @property
    def period(self) -> float:
        """The usual time between two reports, s."""
        at = self.t[np.isfinite(self.heading)]
        if len(at) < 2:
            return _EVERY
        return min(max(_EVERY, float(np.median(np.diff(at)))), _SELDOM)

    @property
    def path(self) -> Array:
        """Length of the true path up to each row (runs only)."""
        steps = np.hypot(np.diff(self.north), np.diff(self.east))
        return np.concatenate(([0.0], np.cumsum(steps)))


def read(file: Path) -> Recording:
    """Read a CSV file. Raises RecordingError for another format, or a file with nothing to
    score."""
    try:
        return _read(file)
    except (UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(f"{file}: no CSV text: {error}") from None


def _read(file: Path) -> Recording:
    with file.open(newline="", encoding="utf-8-sig") as stream:
        rows = csv.DictReader(stream)
        names = tuple(name.strip().lower() for name in rows.fieldnames or ())
        rows.fieldnames = names
        glider = set(_GLIDER) <= set(names)
        if not glider and not set(_RUN) <= set(names):
            run = ", ".join(n for n in _RUN if n not in names)
            glide = ", ".join(n for n in _GLIDER if n not in names)
            raise RecordingError(
                f"{file}: no recording: for a run the columns {run} are missing, "
                f"for a glider {glide}; there are: {', '.join(names)[:80] or 'none'}"
            )
        wanted = (*(_GLIDER if glider else _RUN), *(n for n in _EXTRA if n in names))
        table: dict[str, list[float]] = {name: [] for name in wanted}
        for row in rows:
            for name in wanted:
                table[name].append(_number(row[name]))
    return _recording(str(file), file.name, glider, {n: np.array(v) for n, v in table.items()})


def _number(text: str | None) -> float:
    try:
        return float(text or "nan")
    except ValueError:
        return math.nan


def _usable(glider: bool, table: dict[str, Array]) -> tuple[NDArray[np.bool_], int]:
    """Return which rows can be used, and how many cannot, or not with their position. A glider's
    bad positions are removed from ``table``."""
    time, lat, lon = (_GLIDER[0], *_GLIDER[-2:]) if glider else _RUN[:3]
    whole = [time] if glider else list(_RUN)
    table[lon] = np.where(table[lon] > 180.0, table[lon] - 360.0, table[lon])  # from 0 to 360
    nowhere = (table[lat] == 0.0) & (table[lon] == 0.0)  # some loggers write 0, 0 without a fix
    table[lat] = np.where(nowhere, np.nan, table[lat])
    good = np.all([np.isfinite(table[n]) for n in whole], axis=0)
    good &= ~((np.abs(table[lat]) > 90.0) | (np.abs(table[lon]) > 180.0))
    good[good] &= np.concatenate(([True], np.diff(np.maximum.accumulate(table[time][good])) > 0.0))
    found = np.flatnonzero(good & np.isfinite(table[lat]) & np.isfinite(table[lon]))
    wild = found[~_one_track(table[time][found], table[lat][found], table[lon][found])]
    skipped = int(np.sum(~good)) + len(wild)
    if glider:
        table[lat][wild] = np.nan  # the fix is dropped, the row stays
    else:
        good[wild] = False
    return good, skipped


def _recording(where: str, name: str, glider: bool, raw: dict[str, Array]) -> Recording:
    good, skipped = _usable(glider, raw)
    table = {n: v[good] for n, v in raw.items()}
    time, lat, lon = (_GLIDER[0], *_GLIDER[-2:]) if glider else _RUN[:3]
    adrift = 0 if glider else _cut(table)
    at = np.flatnonzero(np.isfinite(table[lat]) & np.isfinite(table[lon]))
    if len(at) < 2:
        raise RecordingError(_too_few(where, raw, skipped))
    t = table[time]
    start = _date(where, float(t[0])) if glider else _UNDATED
    origin = Position(float(table[lat][at[0]]), float(table[lon][at[0]]))
    frame, north, east = LocalFrame(origin), np.full(len(t), np.nan), np.full(len(t), np.nan)
    for i in at:
        north[i], east[i] = frame.to_local(
            math.radians(float(table[lat][i])), math.radians(float(table[lon][i]))
        )
    unknown = np.full(len(t), np.nan)
    if not glider:
        _long_enough(where, t, np.hypot(np.diff(north), np.diff(east)).sum())
    return Recording(
        name=name,
        glider=glider,
        start=start,
        origin=origin,
        t=t - t[0],
        north=north,
        east=east,
        depth=table["depth_m" if glider else "depth"],
        heading=np.radians(table["heading_mag_deg" if glider else "heading_deg"]),
        pitch=np.radians(table["pitch_deg"]),
        roll=np.radians(table["roll_deg"]),
        altitude=table.get("altitude_m", unknown),
        temperature=table.get("veh_temp_c", unknown),
        own_speed=table.get("speed_est_mps", unknown),
        places=frozenset(zip(_fine(table[lat][at]), _fine(table[lon][at]), strict=True)),
        skipped=skipped,
        adrift=adrift,
    )


def _cut(table: dict[str, Array]) -> int:
    """Keep the longest part of a run in which the vehicle swims: not surfaced between dives, not
    adrift. Return how many rows that removes."""
    t, lat, lon, depth = (table[name] for name in _RUN[:4])
    if len(t) < 2:
        return 0
    east = np.radians(np.diff(lon)) * np.cos(np.radians(lat[1:]))
    steps = EARTH * np.hypot(np.radians(np.diff(lat)), east)
    path = np.concatenate(([0.0], np.cumsum(steps)))
    begin, end = np.maximum(t - _WINDOW, t[0]), np.minimum(t + _WINDOW, t[-1])
    speed = (np.interp(end, t, path) - np.interp(begin, t, path)) / (end - begin)
    up = (depth < _SURFACE) & (float(np.median(depth)) > 2.0 * _SURFACE)
    swims = ~up & (speed >= _SLOW * float(np.median(speed)))
    pieces = np.split(np.arange(len(t)), np.flatnonzero(np.diff(swims.astype(int))) + 1)
    longest = max((piece for piece in pieces if swims[piece[0]]), key=len)
    table |= {name: column[longest] for name, column in table.items()}
    return len(t) - len(longest)


def _fine(degrees: Array) -> list[int]:
    found: list[int] = np.round(1e7 * degrees).astype(np.int64).tolist()
    return found


def _one_track(t: Array, lat: Array, lon: Array) -> NDArray[np.bool_]:
    """Return which places (deg) belong to the longest track that one vehicle can have made."""
    tracks: list[list[int]] = []
    places = list(zip(t.tolist(), lat.tolist(), lon.tolist(), strict=True))
    for i, (now, here, there) in enumerate(places):
        for track in tracks[-_TRACKS:]:
            before, a, b = places[track[-1]]
            north = 60.0 * 1852.0 * (here - a)
            east = 60.0 * 1852.0 * math.remainder(there - b, 360.0) * math.cos(math.radians(here))
            if math.hypot(north, east) <= _FASTEST * (now - before) + _BESIDE:
                track.append(i)
                break
        else:
            tracks.append([i])
    mask = np.zeros(len(t), dtype=np.bool_)
    mask[max(tracks, key=len, default=[])] = True
    return mask


def _too_few(where: str, table: dict[str, Array], skipped: int) -> str:
    rows = max(len(v) for v in table.values())
    empty = [n for n, v in table.items() if n not in _EXTRA and not np.isfinite(v).any()]
    why = f"{rows} rows"
    if skipped:
        why += f", {skipped} {UNUSABLE}"
    if rows and empty:
        why += f"; there is no number in {', '.join(empty)}"
    return f"{where}: fewer than two rows with a time and a position: {why}"


def _date(where: str, seconds: float) -> datetime:
    try:
        return datetime.fromtimestamp(seconds, UTC)
    except (ValueError, OverflowError, OSError):
        raise RecordingError(
            f"{where}: unix_s begins with {seconds:g}, which is no date in s since 1970"
        ) from None


def _long_enough(where: str, t: Array, path: float) -> None:
    if t[-1] - t[0] < SHORTEST or path < NEAREST:
        raise RecordingError(
            f"{where}: too short to be scored: {t[-1] - t[0]:.0f} s and {path:.0f} m; "
            f"a run needs {SHORTEST:.0f} s and {NEAREST:.0f} m"
        )


def surfaced(recording: Recording) -> list[int]:
    """Return the rows with a fix while the antenna is out of the water (depth below 0.5 m)."""
    known = held(recording.depth)
    at = np.flatnonzero(np.isfinite(recording.north) & (known < _SURFACE))
    return [int(i) for i in at]


def held(values: Array) -> Array:
    """Fill gaps with the last value before them."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))
    return values[last]


def wire(
    recording: Recording, fixes: Iterable[int], heading: Array, pwm: int
) -> list[Telemetry | Fix]:
    """Return the decoded messages: @SD every 2 s, and GGA + RMC for the rows ``fixes``."""
    codec, gps, frame = AuvCodec(), NmeaDecoder(), LocalFrame(recording.origin)
    out: list[Telemetry | Fix] = []
    wanted, due = set(fixes), float(recording.t[0])
    for i, t in enumerate(recording.t.tolist()):
        if i in wanted:
            here = frame.to_geodetic(float(recording.north[i]), float(recording.east[i]))
            utc = recording.start + timedelta(seconds=t)
            said = encode_gga(utc, *here) + encode_rmc(utc, *here, speed=None)
            found = [*gps.receive(said, t), *gps.flush(t + 1.0)]
            out += [f for f in found if isinstance(f, Fix)]
        if t >= due and _reported(recording, i):
            due = max(due + _EVERY, t + 0.5 * _EVERY)
            messages = codec.receive(_sd(recording, i, float(heading[i]), pwm), t)
            out += [m for m in messages if isinstance(m, Telemetry)]
    return out


def _reported(recording: Recording, i: int) -> bool:
    return bool(np.isfinite(recording.depth[i]) or np.isfinite(recording.heading[i]))


def _sd(recording: Recording, i: int, heading: float, pwm: int) -> bytes:
    values = {
        "roll_deg": math.degrees(recording.roll[i]),
        "pitch_deg": math.degrees(recording.pitch[i]),
        "yaw_deg": -math.degrees(math.remainder(heading, 2.0 * math.pi)),
        "temperature_c": float(recording.temperature[i]),
        "depth_m": float(recording.depth[i]),
        "altitude_m": float(recording.altitude[i]),
        **dict.fromkeys(MAGNETOMETERS, 0.0),
        **{f"pwm_{name}": NEUTRAL_PWM for name in ACTUATORS},
        "pwm_left_main": pwm,
        "pwm_right_main": pwm,
        "battery_control": 12,
        "battery_power": 48,
    }
    return SD.pack(values)
