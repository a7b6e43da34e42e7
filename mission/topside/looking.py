"""What `auvmission status` learns of a vehicle by its port, and how old that is. Sans-IO.

``@AE`` reports the state and the ages of the last report and fix, ``@VS`` their contents. A vehicle
without ``@AE`` (an older program) reports no age. Then ``@VS`` is requested again, and values that
have changed are new. Under water, where answers take seconds, it is requested only once.

What does not live here: how it is shown (showing).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mission.topside.upload import TRIES, WHAT_LISTENS, WHO_HEARS, Ask, NoAnswer, Script, is_report
from protocol.messages import (
    DataQuery,
    Fix,
    StateQuery,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
)
from protocol.topside import Answer

LOOKS = 3  # a second apart: the slowest board reports every 2 s
SURFACE_M = 0.5
NEW = "new"
_NO_FIX_FOR = "LAST FIX: none has come for"
STALE_S = 5.0  # the vehicle files and the vehicle's own alarm use the same time
FIX_EVERY_S = 2.0


@dataclass(frozen=True, slots=True)
class Looked:
    """The first and the last of the reports, at least ``looks`` seconds apart. ``waited``: s since
    ``state`` was received."""

    first: Status
    last: Status
    store: StoreReport | None
    looks: int
    state: StateReport | None = None
    waited: float = 0.0

    @property
    def is_settled(self) -> bool:
        """Whether a further look would show nothing more."""
        return self.reports == NEW and not self.position.startswith(_NO_FIX_FOR)

    @property
    def report_age(self) -> float | None:
        """s, at most; None if not known, or if no report ever came."""
        return _older(self.state.report_age if self.state else None, self.waited)

    @property
    def fix_age(self) -> float | None:
        return _older(self.state.fix_age if self.state else None, self.waited)

    @property
    def reports(self) -> str:
        if not _tells(self.last):
            return "none: the vehicle has not been heard"
        if (age := self.report_age) is not None:
            told = age - self.waited
            return NEW if told <= STALE_S else f"OLD: the last one is {age:.0f} s old"
        if self.looks == 0:
            return "of an age that is not known"
        if self.last.time != self.first.time:
            return NEW
        return f"OLD: none has come for {self.looks} s; all of it is of that time"

    @property
    def position(self) -> str:
        fix, before, own = self.last.fix, self.first.fix, self.last.telemetry
        if fix is None:
            return "none: no fix so far"
        ago = "" if self.fix_age is None else f"{self.fix_age:.0f} s ago, "
        if own is not None and own.depth is not None and own.depth >= SURFACE_M:
            return f"LAST FIX, {ago}from before it dived; {own.depth:.1f} m deep"
        if self.fix_age is not None:
            is_new = self.fix_age - self.waited <= FIX_EVERY_S
            return NEW if is_new else f"{_NO_FIX_FOR} {self.fix_age:.0f} s"
        if self.looks == 0:
            return "last fix, of an age that is not known"
        if before is None or _place(fix) != _place(before):
            return NEW
        return f"{_NO_FIX_FOR} {self.looks} s"


def look(
    took: Callable[[Looked], None],
    *,
    under_water: bool = False,
    now: Callable[[], float] = lambda: 0.0,
) -> Script:
    """Look at a vehicle. ``now``: any clock of this computer, s. Raises NoAnswer."""
    told = yield Ask("state", StateQuery(), lambda a: isinstance(a, StateReport))
    state, told_at = (told if isinstance(told, StateReport) else None), now()
    first = yield Ask("status", DataQuery(), _is_status)
    if not isinstance(first, Status):
        cause = WHO_HEARS if under_water else WHAT_LISTENS
        raise NoAnswer(f"no answer to @DU after {TRIES} tries; {cause}")
    report = yield Ask("store", StoreQuery(), is_report)
    store = report if isinstance(report, StoreReport) else None
    found = Looked(first, first, store, 0, state, now() - told_at)
    for seconds in range(1, (0 if under_water or state else LOOKS) + 1):
        yield Ask("wait", StoreQuery(), lambda _: False, tries=1)
        again = yield Ask("status", DataQuery(), _is_status)
        if isinstance(again, Status):
            found = Looked(first, again, store, seconds)
        if found.is_settled:
            break
    took(found)
    return ""


def _is_status(answer: Answer) -> bool:
    return isinstance(answer, Status)


def _older(age: float | None, waited: float) -> float | None:
    return None if age is None else age + waited


def _place(fix: Fix) -> tuple[float, float]:
    return fix.latitude, fix.longitude


def _tells(told: Status) -> bool:
    """Whether the status has any value of the vehicle's own sensors."""
    own = told.telemetry
    if own is None:
        return False
    values = (own.depth, own.heading, own.actuators, own.temperature_c, *(own.batteries or ()))
    return any(value is not None for value in values)
