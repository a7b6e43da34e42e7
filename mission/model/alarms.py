"""All alarms: one table with level, words and what to do.

A row's ``judge`` takes a ``Condition``: what a program knows of a vehicle (None: not known). It
returns the words of the alarm, "" if nothing is wrong. The Pi fills in what the runtime and serve
know; the boat's program fills in what it knows of the contact. ``bit`` is the row's place in the
mask of ``@AE``, whose reader has the names but not the words; None: an alarm of the boat alone.

What does not live here: who asks, who receives alarms (onboard, topside), what a limit does
(engine).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from mission.model.tables import Table

WARNING, DANGER = "warning", "danger"  # look at it; act now

UNPROVED_S = 120.0  # of an ascent in which no depth is believed
AFLOAT_S = 60.0  # at the surface without a fix
REFUSED_S = 120.0  # for which a refusal is an alarm
UNSENT_S = 60.0
CLOCK_S = 30.0  # between the Pi's clock and the receiver's
FREE_B = 1_000_000_000  # 8 days of black box
RUNS_OUT_S = 900.0  # until the battery's limit, as it falls now
EMERGENCY = "emergency/"
NO_LINKS: tuple[str, ...] = ()
NO_LIMITS: Mapping[str, str] = {}


@dataclass(frozen=True, slots=True)
class Condition:
    """What is known of a vehicle at one instant; None or empty: not known. Times in s."""

    state: str = ""
    reason: str = ""
    breached: Mapping[str, str] = field(default_factory=lambda: NO_LIMITS)  # limit: its words
    unobeyed: bool = False  # a report contradicts a stop
    unproved: float | None = None  # since an ascent began in which no depth is believed now
    report_age: float | None = None  # inf: none ever came
    reports_within: float = 5.0  # an older report is too old
    afloat_without_fix: float | None = None  # at the surface, with a receiver
    receivers: str = ""  # why the first of two receivers does not count
    refusal: str = ""
    refusal_age: float | None = None
    battery_runs_out: float | None = None  # until its limit, as it falls now
    closed: tuple[str, ...] = NO_LINKS  # links that are disconnected
    unsent_age: float | None = None  # since a command could not be sent
    disk_free: int | None = None  # bytes
    recording: str = ""  # why nothing is recorded, or what was lost
    clock_off: float | None = None  # from the receiver's time
    broken: tuple[str, ...] = NO_LINKS  # what of configuration, vehicle file, store; in words
    silent: float | None = None  # on the boat: since the last answer
    overdue: str = ""  # on the boat: since when, and where to search


@dataclass(frozen=True, slots=True)
class AlarmRow:
    """One kind of alarm. ``bit`` is permanent: that of a removed row is not used again."""

    name: str
    bit: int | None
    level: str
    do: str
    judge: Callable[[Condition], str]


@dataclass(frozen=True, slots=True)
class Alarm:
    """An active alarm. ``words``: "" if only its bit was received."""

    name: str
    level: str
    words: str
    do: str

    def __str__(self) -> str:
        return f"{self.name}: {self.words or 'as the vehicle tells'} - {self.do}"


def _emergency(c: Condition) -> str:
    if not c.state.startswith(EMERGENCY):
        return ""
    return f"{c.state}{f' ({c.reason})' if c.reason else ''}"


def _breached(c: Condition) -> str:
    return "; ".join(c.breached.values())


def _unproved(c: Condition) -> str:
    if c.unproved is None or c.unproved < UNPROVED_S:
        return ""
    return f"it has been on its way up for {c.unproved:.0f} s and believes no depth: it pushes on"


def _report(c: Condition) -> str:
    if c.report_age is None or c.report_age <= c.reports_within:
        return ""
    if c.report_age == float("inf"):
        return "the vehicle's board has never been heard"
    return f"the last report of the vehicle's board is {c.report_age:.0f} s old"


def _fix(c: Condition) -> str:
    if c.afloat_without_fix is None or c.afloat_without_fix < AFLOAT_S:
        return ""
    return f"no fix for {c.afloat_without_fix:.0f} s at the surface"


def _refused(c: Condition) -> str:
    """The refusal and its age. An ``@AR`` that is sent later ends with the age already."""
    if not c.refusal or c.refusal_age is None or c.refusal_age > REFUSED_S:
        return ""
    return c.refusal if c.refusal.endswith(" ago") else f"{c.refusal} ({c.refusal_age:.0f} s ago)"


def _battery(c: Condition) -> str:
    left = c.battery_runs_out
    if left is None or left > RUNS_OUT_S:
        return ""
    return f"as it falls now the control battery reaches its limit in {left / 60:.0f} min"


def _links(c: Condition) -> str:
    return f"away: {', '.join(c.closed)}" if c.closed else ""


def _unsent(c: Condition) -> str:
    if c.unsent_age is None or c.unsent_age > UNSENT_S:
        return ""
    return f"a command could not leave {c.unsent_age:.0f} s ago: the vehicle's port was closed"


def _disk(c: Condition) -> str:
    if c.disk_free is None or c.disk_free >= FREE_B:
        return ""
    return f"{c.disk_free / 1e6:.0f} MB are left on the disk of the black box"


def _clock(c: Condition) -> str:
    if c.clock_off is None or abs(c.clock_off) <= CLOCK_S:
        return ""
    return f"the Pi's clock is {abs(c.clock_off):.0f} s {'ahead' if c.clock_off > 0 else 'behind'}"


def _silent(c: Condition) -> str:
    return "" if c.silent is None else f"the vehicle does not answer; heard {ago(c.silent)}"


def ago(seconds: float) -> str:
    if seconds == float("inf"):
        return "never"
    if seconds < 120.0:
        return f"{seconds:.0f} s ago"
    return f"{seconds / 60:.0f} min ago" if seconds < 7200.0 else f"{seconds / 3600:.1f} h ago"


_ROWS = (
    AlarmRow("emergency", 0, DANGER, "find out why, then `auvmission clear` at the surface",
             _emergency),
    AlarmRow("limit", 1, DANGER, "in a mission the vehicle surfaces by itself; else bring it up",
             _breached),
    AlarmRow("stop not obeyed", 2, DANGER, "keep clear of it; the stop is sent again and again",
             lambda c: "a report shows way after the stop" if c.unobeyed else ""),
    AlarmRow("old report", 3, DANGER, "nothing shown of its sensors is of now; the AUV's board "
             "reports nothing under the stick, else look at it, its power and the cable", _report),
    AlarmRow("no fix", 4, WARNING, "free view of the sky; is the receiver's node open?", _fix),
    AlarmRow("refused", 5, WARNING, "do what it says, or say something else", _refused),
    AlarmRow("battery", 6, WARNING, "end the mission while there is power for the way up",
             _battery),
    AlarmRow("link away", 7, DANGER, "look at the cable and at `auvmission doctor`", _links),
    AlarmRow("NOT SENT", 8, DANGER, "what the vehicle was told last holds; look at its port",
             _unsent),
    AlarmRow("disk", 9, WARNING, "move old black boxes away", _disk),
    AlarmRow("black box", 10, WARNING, "the dive is not recorded whole: look at the disk",
             lambda c: c.recording),
    AlarmRow("clock", 11, WARNING, "set it in idle: `auvmission time`", _clock),
    AlarmRow("broken", 12, DANGER, "mend it, then restart serve at the surface",
             lambda c: "; ".join(c.broken)),
    AlarmRow("receiver", 13, WARNING, "look at the first receiver and its cable; the second has to "
             "last", lambda c: c.receivers),
    AlarmRow("surface unproved", 14, DANGER, "a fix ends it; where you see it at the surface and "
             "hold it: `auvmission stop`, then `auvmission clear`", _unproved),
    AlarmRow("no contact", None, WARNING, "it goes on by itself; ask again, nearer, or by another "
             "way", _silent),
    AlarmRow("OVERDUE", None, DANGER, "search, and call for help before the battery ends",
             lambda c: c.overdue),
)  # fmt: skip


def _fault(row: AlarmRow, others: Iterable[AlarmRow]) -> str:
    if row.bit is not None and not 0 <= row.bit < 16:
        return f"{row.name}: @AE has bits 0 to 15"
    taken = [other.name for other in others if row.bit is not None and other.bit == row.bit]
    return f"{row.name}: {taken[0]} has bit {row.bit} already" if taken else ""


ALARMS: Table[str, AlarmRow] = Table(lambda row: row.name, _ROWS, _fault)


def standing(condition: Condition) -> tuple[Alarm, ...]:
    """Return the active alarms, in the order of the table."""
    found = ((row, row.judge(condition)) for row in ALARMS.values())
    return tuple(Alarm(row.name, row.level, words, row.do) for row, words in found if words)


def mask_of(names: Iterable[str]) -> int:
    bits = (ALARMS[name].bit for name in names)
    return sum({1 << bit for bit in bits if bit is not None})


def alarms_of(mask: int) -> tuple[Alarm, ...]:
    """Return the alarms of a received mask; a bit without a row here is a newer vehicle's."""
    rows = {row.bit: row for row in ALARMS.values() if row.bit is not None}
    found = []
    for bit in range(16):
        if mask >> bit & 1 and (row := rows.get(bit)) is not None:
            found.append(Alarm(row.name, row.level, "", row.do))
        elif mask >> bit & 1:
            do = "look at `auvmission status --local` on the Pi"
            found.append(Alarm(f"alarm {bit}", DANGER, "of a newer vehicle", do))
    return tuple(found)
