"""A trial as timelines, for the laws over the whole flight.

    stays     the states one after the other, "dead" while no program lives
    told      when the program took a report of the vehicle, with the estimate that followed
    words     the bytes to the vehicle
    said      the bytes of the operators
    depth     the true depth at any time
    faulty    whether a fault of some kind was there, or its traces
    hindered  whether the program could not do its part: dead, stalled, its cable pulled

What does not live here: the laws (whole_flight and the modules that it names).
"""

from __future__ import annotations

import bisect
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import compress, pairwise

from links.simulated.settings import FaultEvent, Settings
from mission.model import (
    AUTONOMOUS,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    Mission,
    Step,
    Tx,
)
from mission.model.vehicle import Vehicle
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.excuses import auto_closed
from mission.verification.campaign.laws import Span, spans
from mission.verification.campaign.reports import reports
from mission.verification.campaign.trial import fault_ends
from mission.verification.rig.acts import TOPSIDE, Act
from mission.verification.rig.program import DEAD
from mission.verification.rig.speech import MOTION, Speech
from mission.verification.rig.trace import Done, Heard, Said, Told, Trace

_BETWEEN = 0.9  # s at least between two samples (R5)
SAME = 1e-3  # s
TRACES = 30.0  # s for which a fault that is over may still be felt
_LOOKS_WELL = ("stuck", "drifting", "late", "too_")
_LEAP = 3.0  # m: 2 m/s from one report to the next (R5), and noise
_POWER = b"@RS"
_AFLOAT, _SHOWN = 0.5, 25.0  # m and s: the first fix, 10 s of them, and the window before
_KNOWN = 6.0  # s until the program knows that a node is open again
AGAIN = 1.5  # s from the end of a hindrance until everything is as before
UPWARD_WORDS = (b"@ZAWF$", b"@ZAU12$")
STOP_WORD, DOWN_WORD = b"@ZAX0$", b"@ZAD12$"
_RESTS = (STOPPED, SURFACED, MANUAL_WAITING)
_ASCENDS = ("emergency surfacing", "surge 0 heave -1")
_M = re.compile(rb"@M[^@$]{2,10}\$")


@dataclass(frozen=True, slots=True)
class Stay:
    """A time in one state; ``step`` led to it, None if none did (boot, dead)."""

    state: str
    begin: float
    end: float
    before: str
    step: Step | None

    @property
    def autonomous(self) -> bool:
        return self.state.startswith(AUTONOMOUS)

    @property
    def rests(self) -> bool:
        """Whether everything should be stopped."""
        return self.state.startswith("idle") or self.state in _RESTS

    @property
    def ascends(self) -> bool:
        """Whether this is the emergency's ascent, or a leg's."""
        if self.state == SURFACING or self.step is None:
            return self.state == SURFACING
        return self.autonomous and any(a.startswith(_ASCENDS) for a in self.step.actions)


def apart(times: Iterable[float]) -> Iterator[bool]:
    """Yield for each time, s, whether it is at least 0.9 s after the last that counted (R5).

    A fast board reports many times what its sensor measured once.
    """
    last = -math.inf
    for t in times:
        is_next = t >= last + _BETWEEN
        last = t if is_next else last
        yield is_next


class Story:
    """``silence``: the longest allowed one of the topside, s; None if any length is allowed."""

    def __init__(
        self,
        trial: Trace,
        mission: Mission,
        vehicle: Vehicle,
        profile: str,
        settings: Settings,
        silence: float | None = None,
    ) -> None:
        self.trial, self.mission, self.vehicle = trial, mission, vehicle
        self.profile, self.settings, self.silence = profile, settings, silence
        events = trial.events
        self.end = trial.truth.t
        self.steps = [e for e in events if isinstance(e, Step)]
        self.told = [e for e in events if isinstance(e, Told)]
        self.board = Speech(vehicle) if vehicle.codec in MOTION else None
        self.upward = _upward(self.board)
        self.words = [e for e in events if isinstance(e, Tx) and e.link == VEHICLE]
        if self.board is not None:
            self.words = [replace(e, data=self.board.word(e.data)) for e in self.words]
        self.stick = list(self._stick())
        self.answers = [e for e in events if isinstance(e, Tx) and e.link != VEHICLE]
        self.said = [e for e in events if isinstance(e, Said)]
        self.heard = [e for e in events if isinstance(e, Heard)]
        self.done = [e for e in events if isinstance(e, Done)]
        self.stays = list(self._stays())
        self.reports = list(reports(self.heard, vehicle))
        self.spans: list[Span] = list(spans(trial, mission, vehicle))
        self._depths = [place.depth for place in trial.track]
        self._told_at = [told.t for told in self.told]
        self._word_at = [word.t for word in self.words]
        self._hindered = list(self._hindrances())
        self._closed = list(auto_closed(events))

    # --- how it came about -----------------------------------------------------------------------

    def _stays(self) -> Iterator[Stay]:
        now = Stay("idle/empty", 0.0, 0.0, "", None)
        for event in self.trial.events:
            state, step = "", None
            if isinstance(event, Step) and event.entered:
                state, step = event.entered[-1], event
            elif isinstance(event, Done) and event.act is Act.KILL:
                state = DEAD
            elif isinstance(event, Done) and event.act is Act.BOOT:
                state = "idle/empty"
            if state:
                yield Stay(now.state, now.begin, event.t, now.before, now.step)
                now = Stay(state, event.t, event.t, now.state, step)
        yield Stay(now.state, now.begin, self.end, now.before, now.step)

    def _stick(self) -> Iterator[float]:
        """Yield when an M left for the vehicle; of a board, when an M came that it can obey."""
        if self.board is None:
            yield from (word.t for word in self.words if word.data[:2] == b"@M")
            return
        for event in self.trial.events:
            if isinstance(event, Said) and event.link == TOPSIDE:
                words = _M.findall(event.data)
                yield from (event.t for word in words if self.board.steers(word))

    def _hindrances(self) -> Iterator[tuple[float, float]]:
        pairs = {
            Act.KILL: (Act.BOOT,),
            Act.STALL: (Act.RUN, Act.KILL),
            Act.UNPLUG: (Act.PLUG,),
        }
        for i, done in enumerate(self.done):
            if done.act in pairs:
                later = (d.t for d in self.done[i + 1 :] if d.act in pairs[done.act])
                yield done.t, next(later, math.inf) + AGAIN
            elif done.act is Act.POWER:
                yield done.t, done.t + AGAIN

    # --- what is asked ---------------------------------------------------------------------------

    def depth(self, t: float) -> float:
        """Return the true depth at ``t``, m; linear between the seconds."""
        at = min(max(t, 0.0), len(self._depths) - 1.001)
        i = int(at)
        return self._depths[i] + (at - i) * (
            self._depths[min(i + 1, len(self._depths) - 1)] - self._depths[i]
        )

    def deepest(self, begin: float, end: float) -> float:
        inside = self._depths[math.ceil(max(begin, 0.0)) : int(end) + 1]
        return max([*inside, self.depth(begin), self.depth(end)])

    def tilt(self, t: float) -> float:
        """Return the angle from upright, rad."""
        place = self.trial.track[min(int(t), len(self.trial.track) - 1)]
        return math.acos(math.cos(place.roll) * math.cos(place.pitch))

    def heel(self, t: float) -> float:
        """Return the greater of roll and pitch, rad, by which R7 calls a vehicle upside down."""
        place = self.trial.track[min(int(t), len(self.trial.track) - 1)]
        return max(math.acos(math.cos(place.roll)), math.acos(math.cos(place.pitch)))

    def told_in(self, begin: float, end: float) -> Sequence[Told]:
        """Return the reports after ``begin`` and before ``end``."""
        low, high = (
            bisect.bisect_right(self._told_at, begin),
            bisect.bisect_left(self._told_at, end),
        )
        return self.told[low:high]

    def told_before(self, t: float) -> float:
        """When the last report before ``t`` was taken; ``t`` if none was."""
        low = bisect.bisect_left(self._told_at, t)
        return self._told_at[low - 1] if low else t

    def samples_in(self, begin: float, end: float) -> Iterator[Told]:
        """Yield the reports that limits count: at least 0.9 s apart (R5)."""
        told = self.told_in(begin, end)
        return compress(told, apart(each.t for each in told))

    def words_in(self, begin: float, end: float) -> Sequence[Tx]:
        """Return the bytes to the vehicle from ``begin`` to ``end``, inclusive, with rounding."""
        low = bisect.bisect_left(self._word_at, begin - SAME)
        high = bisect.bisect_right(self._word_at, end + SAME)
        return self.words[low:high]

    def faults(self, names: Iterable[str], begin: float, end: float) -> list[FaultEvent]:
        """Return the faults whose names begin so, and that last or leave traces in this time."""
        prefixes = tuple(names)
        return [
            fault
            for fault in self.settings.faults
            if fault.name.startswith(prefixes)
            and fault.begin <= end
            and fault_ends(fault) + TRACES >= begin
        ]

    def faulty(self, names: Iterable[str], begin: float, end: float) -> bool:
        return bool(self.faults(names, begin, end))

    def is_switched(self, begin: float, end: float) -> bool:
        """Whether an operator has switched the power of sensors in this time (@RS)."""
        return any(word.data.startswith(_POWER) for word in self.words_in(begin, end))

    def has_leapt(self, t: float) -> bool:
        """Whether the depth may still not be believed at ``t``, after a leap or a vain push (R5).

        A depth that was wrong but looked healthy, or that came back with a leap, is believed again
        once it has shown the surface for as long as fixes take; before that, perhaps not. The same
        holds for a true depth after weak verticals pushed in vain.
        """
        weak = [f for f in self.settings.faults if f.name.startswith("verticals_") and f.begin < t]
        if any(not self._has_shown(self._pushed_at(f, t), t) for f in weak):
            return True
        over = [(f, fault_ends(f)) for f in self.settings.faults if f.name.startswith("depth_")]
        return any(
            end < t and self._leap(f, end) > _LEAP and not self._has_shown(end, t)
            for f, end in over
        )

    def _pushed_at(self, fault: FaultEvent, t: float) -> float:
        """Return when the verticals last pushed in vain before ``t``, by the reports.

        The earliest such time is the begin of the fault.
        """
        pushes = (
            report.t
            for report in self.reports
            if fault.begin <= report.t <= min(t, fault_ends(fault)) and report.pushing
        )
        return max(pushes, default=fault.begin)

    def _leap(self, fault: FaultEvent, over: float) -> float:
        """Return by how many m the reported depth leaps as the fault ends.

        It is infinite for a fault that looked healthy: its depth was contradicted.
        """
        kind = fault.name.removeprefix("depth_")
        if kind in ("frozen", "silent", "intermittent"):
            return abs(self.depth(over) - self.depth(fault.begin))
        if kind == "dead":  # it reports 0, and leaps both ways
            return max(self.depth(fault.begin), self.depth(over))
        return math.inf if kind.startswith(_LOOKS_WELL) else 0.0

    def _has_shown(self, begin: float, end: float) -> bool:
        """Whether the vehicle was at the surface for ``_SHOWN`` s, with fixes."""
        since = begin
        for place in self.trial.track[math.ceil(begin) : int(end) + 1]:
            if place.depth > _AFLOAT or self.faulty(("gps_",), place.t, place.t):
                since = place.t
            elif place.t - since > _SHOWN:
                return True
        return False

    def hindered(self, begin: float, end: float) -> bool:
        return any(b <= end and e >= begin for b, e in self._hindered)

    def auto_opens(self, t: float) -> float:
        """Return the first time from ``t`` on at which node AUTO is open."""
        return next((e + _KNOWN for b, e in self._closed if b <= t <= e + _KNOWN), t)

    def auto_closed(self, begin: float, end: float) -> bool:
        return any(b <= end and e + _KNOWN >= begin for b, e in self._closed)

    def stay_at(self, t: float) -> Stay:
        at = bisect.bisect_right([stay.begin for stay in self.stays], t) - 1
        return self.stays[max(at, 0)]

    def flights(self) -> Iterator[list[Stay]]:
        """Yield the stays in legs that follow one another without a break."""
        part: list[Stay] = []
        for stay in self.stays:
            if stay.autonomous:
                part.append(stay)
            elif part:
                yield part
                part = []
        if part:
            yield part

    def flat(
        self, begin: float, end: float, within: int, most: float, deep: float
    ) -> Iterator[tuple[float, float]]:
        """Yield times deeper than ``deep`` m without a rise by ``most`` m in ``within`` s."""
        depths, since = self._depths, None
        last = min(int(end), len(depths) - 1) - within
        for i in range(math.ceil(begin), last + 1):
            level = depths[i] > deep and depths[i] - depths[i + within] < most
            if level and since is None:
                since = i
            elif not level and since is not None:
                yield float(since), float(i - 1 + within)
                since = None
        if since is not None:
            yield float(since), float(last + within)


def _upward(board: Speech | None) -> tuple[bytes, ...]:
    """Return the commands that bring the vehicle up, no two of the same bytes."""
    if board is None:
        return UPWARD_WORDS
    return (b"@ZAU12$",) if board.lifts else ()


def gaps(times: Iterable[float], begin: float, end: float) -> Iterator[tuple[float, float]]:
    """Yield the gaps between neighbouring times; ``begin`` and ``end`` count as times."""
    yield from pairwise([begin, *(t for t in times if begin < t < end), end])
