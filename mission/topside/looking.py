"""What `auvmission status` can know of the age of what it shows. Sans-IO.

``@VS`` keeps the last fix, and the last report where none comes any more, for hours (R9). Neither
has an age in that frame; so it is asked for again, and what has changed since is new. Under water,
where each answer takes seconds, it is asked for once.

What does not live here: how it is shown (commands.operator).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mission.topside.upload import TRIES, WHAT_LISTENS, Ask, NoAnswer, Script, is_report
from protocol.messages import DataQuery, Fix, Status, StoreQuery, StoreReport
from protocol.topside import Answer

LOOKS = 3  # a second apart: the slowest board reports every 2 s
SURFACE_M = 0.5
NEW = "new"
_NO_FIX_FOR = "LAST FIX: none has come for"


@dataclass(frozen=True, slots=True)
class Looked:
    """The first and the last of the reports, ``looks`` seconds apart at least."""

    first: Status
    last: Status
    store: StoreReport | None
    looks: int

    @property
    def is_settled(self) -> bool:
        """A further look would tell nothing more."""
        return self.reports == NEW and not self.position.startswith(_NO_FIX_FOR)

    @property
    def reports(self) -> str:
        if not _tells(self.last):
            return "none: the vehicle has not been heard"
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
        if own is not None and own.depth is not None and own.depth >= SURFACE_M:
            return f"LAST FIX, from before it dived; {own.depth:.1f} m deep"
        if self.looks == 0:
            return "last fix, of an age that is not known"
        if before is None or _place(fix) != _place(before):
            return NEW
        return f"{_NO_FIX_FOR} {self.looks} s"


def look(took: Callable[[Looked], None], *, under_water: bool = False) -> Script:
    """Raises NoAnswer."""
    first = yield Ask("status", DataQuery(), _is_status)
    if not isinstance(first, Status):
        raise NoAnswer(f"no answer to @DU after {TRIES} tries; {WHAT_LISTENS}")
    report = yield Ask("store", StoreQuery(), is_report)
    store = report if isinstance(report, StoreReport) else None
    found, looks = Looked(first, first, store, 0), 0 if under_water else LOOKS
    for seconds in range(1, looks + 1):
        yield Ask("wait", StoreQuery(), lambda _: False, tries=1)
        told = yield Ask("status", DataQuery(), _is_status)
        if isinstance(told, Status):
            found = Looked(first, told, store, seconds)
        if found.is_settled:
            break
    took(found)
    return ""


def _is_status(answer: Answer) -> bool:
    return isinstance(answer, Status)


def _place(fix: Fix) -> tuple[float, float]:
    return fix.latitude, fix.longitude


def _tells(told: Status) -> bool:
    """Anything of the vehicle's own sensors."""
    own = told.telemetry
    if own is None:
        return False
    values = (own.depth, own.heading, own.actuators, own.temperature_c, *(own.batteries or ()))
    return any(value is not None for value in values)
