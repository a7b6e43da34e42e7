"""Calendar times as document 000 writes them: ``YYYY/MM/DD hh:mm:ss`` (@ST) and with dashes (@VS).

Outside the frames a time is ``YYYY-MM-DDThh:mm:ss``. What does not live here: time zones and
clocks (R10).
"""

from __future__ import annotations

import datetime
import itertools
import re
from collections.abc import Mapping
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, required
from protocol.text import Refused

_CLOCK = "([0-9]{2}):([0-9]{2}):([0-9]{2})"
SLASHES = re.compile(f"([0-9]{{4}})/([0-9]{{2}})/([0-9]{{2}}) {_CLOCK}")
DASHES = re.compile(f"([0-9]{{4}})-([0-9]{{2}})-([0-9]{{2}})-{_CLOCK}")
ISO = re.compile(f"([0-9]{{4}})-([0-9]{{2}})-([0-9]{{2}})T{_CLOCK}")

YEARS = range(1970, 2100)  # to which a vehicle's clock may be set (R10)
Clock = tuple[int, ...]  # year, month, day, hour, minute, second


def split(text: str, form: re.Pattern[str]) -> Clock:
    """Read a time written in ``form``. Raises Refused for any other form."""
    match = form.fullmatch(text)
    if match is None:
        raise Refused(FaultKind.NON_NUMERIC)
    return tuple(map(int, match.groups()))


def split_compact(text: str) -> Clock:
    cuts = (0, 4, 6, 8, 10, 12, 14)
    return tuple(int(text[a:b]) for a, b in itertools.pairwise(cuts))


def real(clock: Clock) -> bool:
    """Whether this time exists on the calendar; second 60 does not."""
    year, month, day, hour, minute, second = clock
    try:
        datetime.datetime(year, month, day, hour, minute, second)  # noqa: DTZ001  # no zone meant
    except ValueError:
        return False
    return True


def iso(clock: Clock) -> str:
    year, month, day, hour, minute, second = clock
    return f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}"


def checked(clock: Clock) -> str:
    """Return the time in ISO form. Raises Refused if it is not real or outside YEARS."""
    if clock[0] not in YEARS or not real(clock):
        raise Refused(FaultKind.OUT_OF_RANGE)
    return iso(clock)


def encodable(values: Mapping[str, Any], frame: str) -> Clock:
    """Read the value ``time``. Raises CannotEncode."""
    text = required(values, "time", frame)
    match = ISO.fullmatch(text) if isinstance(text, str) else None
    clock = tuple(map(int, match.groups())) if match else ()
    if not clock or not real(clock):
        raise CannotEncode(f"{frame}: time is YYYY-MM-DDThh:mm:ss of a real day, not {text!r}")
    return clock
