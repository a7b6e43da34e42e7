"""The story of a dive: what was flown, why each leg ended, how near the limits were.

    recordings --Teller--> Chapter (paragraphs and tables) --text | markdown | HTML (tell)

Every sentence follows from the records. Gaps in a damaged file are reported as gaps. What does not
live here: single lines (journal), pictures (report), how it is printed (tell).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from mission.analysis.chapters import Chapter, tabled
from mission.analysis.doubts import Doubts, Spell, doubted_depth, summed
from mission.analysis.ended import ended_by
from mission.analysis.extremes import Extremes
from mission.analysis.gathered import UNITS, Least, Leg, Told
from mission.analysis.journal import goes_on, restart
from mission.analysis.lastly import Lastly
from mission.analysis.unsaid import Absence, Power, Unsaid
from mission.engine.limits import LIMITS
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE, By, Chart, Position, Record, Step, Tx
from mission.model.regions import EMERGENCY
from mission.model.shown import clock
from mission.onboard.blackbox import Gap
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.runtime import VEHICLE
from mission.onboard.stream.derived import MARGINS, Derivation, Message
from mission.onboard.stream.events import answers_in, bound_of, reason_of
from mission.onboard.stream.topics import FIX, JOURNAL, STATE, TELEMETRY
from mission.onboard.stream.wellknown import INFO

REFUSED = "refused "  # how the engine's event of a refusal begins
_CUT_SHORT = frozenset({By.TIMEOUT, By.ELSE, By.ON, By.UNCERTAIN})
_OPERATORS = frozenset({"topside", "modem"})
_ON_ITS_BEHALF = "answer of the STM32"  # reason of answers for the STM32, also if it gave none


def story(recordings: Sequence[Sequence[Record | Gap]]) -> list[Chapter]:
    """Tell the story of recordings, which are sorted by their starts. Raises ValueError, KeyError
    or TypeError for a start record of a version that cannot be read."""
    chapters: list[Chapter] = []
    home: Position | None = None
    for number, items in enumerate(recordings):
        if number:
            chapters.append(between(recordings[number - 1], items))
            home = home if goes_on(recordings[number - 1], items) else None
        teller = Teller(items, home=home)
        chapters += teller.chapters()
        home = teller.home
    return chapters


def between(before: Sequence[Record | Gap], after: Sequence[Record | Gap]) -> Chapter:
    says = restart(before, after).strip("- ")
    whole = [f"{says[0].upper()}{says[1:]}."]
    if "began again" in says:
        told = any(isinstance(one, Record) and one.kind == rec.ENDING for one in before)
        whole.append("It had been told to end." if told else "Why it ended is not on record.")
    return Chapter("Between two recordings", tuple(whole))


Seen = Callable[[Record, Sequence[Message], Derivation], None]


class Teller:
    """The story of one recording."""

    def __init__(
        self,
        items: Iterable[Record | Gap],
        seen: Seen | None = None,
        home: Position | None = None,
    ) -> None:
        """``seen`` gets each record with the messages derived from it, so that nothing is derived
        twice. ``home``: that of the recording before, if the program only restarted."""
        self._seen, self._lastly = seen, Lastly(home=home)
        self._told = Told()
        self._derivation: Derivation | None = None
        self._doubts: Doubts | None = None
        self._flown: Chart | None = None  # the mission that was started last
        self._unsaid, self._absence, self._extremes = Unsaid(), Absence(), Extremes()
        self._power = Power()
        self._acting: frozenset[str] = frozenset()  # limits for which the vehicle has the reports
        self._bounds: dict[str, float] = {}  # the latest limits in force
        self._breached: frozenset[str] | None = None  # limits; None until the first are known
        self._end, self._state = 0.0, ""
        self._fixes: list[float] = []  # when the fixes came, s
        self._acknowledged = b""  # the vehicle's last bytes that contain an acknowledgement
        for item in items:
            if isinstance(item, Gap):
                self._gap(item)
            else:
                self._take(item)

    # --- what is gathered ------------------------------------------------------------------------

    def _gap(self, gap: Gap) -> None:
        if not gap.whole:
            self._told.says.append(f"Not everything is on record: {gap}.")
            self._unsaid.forget()

    def _take(self, record: Record) -> None:
        self._end = max(self._end, record.t)
        if self._derivation is None or self._doubts is None:
            if record.kind != rec.START:
                return
            self._derivation = Derivation(record)
            self._doubts = Doubts(self._derivation.start.vehicle)
            self._begin(self._derivation.start)
        self._doubts.receive(record)
        self._absence.receive(record)
        if record.kind == rec.STEP:
            self._step(rec.step_of(record.payload), self._derivation)
        elif record.kind == rec.TX:
            self._sent(record)
        elif record.kind == rec.RX:
            self._came(record)
        messages = list(self._derivation.receive(record))
        for message in messages:
            self._message(message, self._derivation, self._doubts)
        if record.kind == rec.STANDING:
            self._stand(record.t, rec.read_standing(record))
        if self._seen is not None:
            self._seen(record, messages, self._derivation)

    def _message(self, message: Message, derivation: Derivation, doubts: Doubts) -> None:
        believed = doubts.believes("depth", message.t)
        if message.topic == STATE:
            self._look(message.t, message.value, derivation)
        elif message.topic == JOURNAL:
            self._journal(message.t, message.value)
        elif message.topic == TELEMETRY:
            depth = message.value["depth_m"]
            absurd = doubts.reason("depth", message.t) == "absurd"
            self._told.again.report(None if absurd else depth)
            self._extremes.last = depth if believed else None
            if believed and self._under_way:
                self._extremes.report(message.t, depth)
                self._near_depth(message.t, depth, derivation)
        origin = self._origin
        by_hand = self._state.startswith("manual")
        self._lastly.receive(message)
        if message.topic == FIX:
            self._fixes.append(message.t)
        self._told.says += self._unsaid.receive(message, origin, believed, by_hand)

    def _begin(self, start: rec.Start) -> None:
        when = datetime.fromtimestamp(start.wall, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
        says = f"The program (version {start.version}, vehicle {start.vehicle.name}) began {when}."
        self._told.says.append(says)
        self._unsaid = Unsaid("position" in start.vehicle.reports)
        self._extremes = Extremes()
        self._lastly = Lastly(start.vehicle.reports, self._lastly.home(None))
        self._acting = frozenset(n for n, r in LIMITS.items() if not r.disarmed(start.vehicle))
        if start.store.under_way:
            before = f"Before, it had been interrupted: {start.store.under_way} was under way."
            self._told.says.append(before)

    def _stand(self, t: float, standing: rec.Standing) -> None:
        if standing.commander:
            self._told.commanders[standing.commander] = None
        self._limited(t, standing)
        breached, before = frozenset(standing.breached), self._breached
        self._breached = breached
        for limit in sorted(breached - (breached if before is None else before)):
            self._told.alarms.add(t, "limit", f"{limit} is breached{bound_of(limit)}")

    def _limited(self, t: float, standing: rec.Standing) -> None:
        """Report limits that change, by an operator's @SP or by the mission that is loaded."""
        bounds = {name: float(getattr(standing, name)) for name in UNITS}
        before, self._bounds = self._bounds or bounds, bounds
        if changed := [name for name in bounds if bounds[name] != before[name]]:
            says = (f"{n} {bounds[n]:g} {UNITS[n]}, was {before[n]:g}" for n in changed)
            self._told.says.append(f"{clock(t)}: limits in force: {'; '.join(says)}.")

    def _step(self, step: Step, derivation: Derivation) -> None:
        if step.event.startswith(REFUSED):
            frame = step.event.removeprefix(REFUSED)
            self._told.refusals.add(step.t, frame, "the vehicle answered N", VEHICLE)
        self._lastly.step(step)
        if not step.entered:
            self._tell_again(step)
            return
        self._told.again.end()
        path, told, chart = step.entered[-1], self._told, derivation.chart
        seen = [pair for evaluation in step.evaluations for pair in evaluation.values]
        words = ended_by(chart, step.trigger, seen) if chart else None
        because = words or reason_of(step)
        if words and step.by is By.ELSE and step.event.startswith(REFUSED):
            because = f"the vehicle {step.event}"
        elif step.by is By.ELSE and any(value is None for _, value in seen):
            because = because.replace("refused or blind", "blind")
        elif step.trigger == "surfaced":
            because += self._proof(step)
        if told.legs and told.legs[-1].left is None:
            told.legs[-1].left, told.legs[-1].because = step.t, because
        self._tell_state(step, path, derivation, because)
        if path.startswith(f"{AUTONOMOUS}/"):
            told.legs.append(Leg(path, step.t))
        self._state = path

    def _proof(self, step: Step) -> str:
        """Describe what proved the surface: a fix, or a shallow depth that lasted."""
        blind = self._doubts is not None and not self._doubts.believes("depth", step.t)
        if step.event != "fix":
            return ", proved by a depth that stayed shallow"
        alone = ", proved by fixes alone, for no depth can be believed"
        return alone if blind else ", proved by a fix"

    def _tell_again(self, step: Step) -> None:
        """Report a limit that acts by commands without another state, or an ascent that
        continues."""
        for action in step.actions:
            what, _, why = action.partition(": ")
            if what.startswith("output "):
                self._told.says.append(f"{clock(step.t)}: {why}: {what.removeprefix('output ')}.")
            elif why.startswith("limit ") or self._state.startswith(EMERGENCY):
                self._told.again.add(step.t, what, why, self._told.says)

    def _tell_state(self, step: Step, path: str, derivation: Derivation, because: str) -> None:
        told, chart = self._told, derivation.chart
        was_flying, flies = (p.startswith(f"{AUTONOMOUS}/") for p in (self._state, path))
        at = clock(step.t)
        if flies and not was_flying and chart is not None:
            verb = "went on" if self._state.startswith("manual") else "was started"
            self._flown = chart
            name = f"{chart.mission.name} ({chart.digest[:8]})"
            told.says.append(f"{at}: the mission {name} {verb} by {step.event}.")
        elif path.startswith(EMERGENCY):
            told.says.append(f"{at}: emergency, now {path}: {because}.")
        elif was_flying and flies and step.by in _CUT_SHORT:
            leg, then = (p.partition("/")[2] for p in (self._state, path))
            told.says.append(f"{at}: {leg} was cut short, then {then}: {because}.")
        elif was_flying and not flies:
            told.says.append(f"{at}: the mission ended, now {path}: {because}.")
        elif path.startswith("manual") or self._state.startswith(("manual", EMERGENCY)):
            told.says.append(f"{at}: now {path}: {because}.")

    def _came(self, record: Record) -> None:
        rx = rec.read_rx(record)
        if rx.link == VEHICLE:
            self._told.commands.heard(rx.data)
            self._acknowledged = rx.data if b"@ACK_" in rx.data else self._acknowledged
        elif rx.link in _OPERATORS:
            self._told.words.said(rx.t, f"{rx.link} {rx.address}".rstrip(), rx.data)

    def _sent(self, record: Record) -> None:
        tx = rec.read_tx(record)
        if tx.link == VEHICLE:
            self._told.commands.add(tx.t, tx.data, tx.reason)
            self._told.says += self._power.sent(tx.t, tx.data)
            return
        who = f"{tx.link} {tx.address}".rstrip()
        self._told.words.add(tx.t, who, tx.data)
        for word, refused in answers_in(tx.data):
            if refused:
                why = self._refused_by(tx, word, who)
                self._told.refusals.add(tx.t, f"@ACK_{word}N$", why, who)

    def _refused_by(self, tx: Tx, word: str, who: str) -> str:
        """Return why an operator got an N. For commands that are passed on to the vehicle, also
        tell whether the vehicle answered N or did not answer."""
        if tx.reason != _ON_ITS_BEHALF:
            return tx.reason
        refused = f"@ACK_{word}N$".encode() in self._acknowledged
        why = "the vehicle answered N" if refused else "the vehicle gave no answer"
        self._told.says.append(f"{clock(tx.t)}: {who} got N for @{word}: {why}.")
        return why

    def _journal(self, t: float, said: Mapping[str, Any]) -> None:
        if said["level"] <= INFO:
            if said["name"] == "store" and t > 0.0:
                self._told.says.append(f"{clock(t)}: {said['message']}.")
        elif not said["message"].startswith("refused"):  # refusals have their own table
            self._told.alarms.add(t, said["name"], said["message"])

    def _look(self, t: float, state: Mapping[str, Any], derivation: Derivation) -> None:
        standing = derivation.standing
        if not self._under_way or standing is None:
            return
        low = self._doubts is not None and self._doubts.believes("altitude", t)
        self._extremes.state(t, state, low, self._lastly.away(state))
        for name in MARGINS:
            limit = name.removeprefix("to_").rpartition("_")[0]
            if limit != "depth":
                self._near(t, limit, state[name], standing)

    def _near_depth(self, t: float, depth: float | None, derivation: Derivation) -> None:
        """Use the report, because the limit uses it too; the estimate's depth is smoothed."""
        standing = derivation.standing
        if depth is not None and standing is not None:
            self._near(t, "depth", standing.depth - depth, standing)

    def _near(self, t: float, limit: str, left: float | None, standing: rec.Standing) -> None:
        least = self._told.least.get(limit)
        if left is None or limit not in self._acting or (least and left >= least.left):
            return
        self._told.least[limit] = Least(left, t, getattr(standing, limit))

    # --- what is told ----------------------------------------------------------------------------

    def chapters(self) -> Iterator[Chapter]:
        told = self._told
        if self._derivation is None:
            says = "There is no whole start record, so nothing says what vehicle it is."
            yield Chapter("A recording", (*told.says, says))
            return
        if told.commanders:
            told.says.append(f"Who commanded: {', '.join(told.commanders)}.")
        if self._under_way:
            told.says += self._never_flown()
            told.says += self._extremes.says()
        told.says += told.refusals.of(VEHICLE)
        told.says += doubted_depth(self.spells(), self._fixes)
        told.says += (*told.commands.in_vain(), *self._unsaid.at_last(self._end))
        told.says += self._absence.at_last(self._end)
        known = self._extremes.last is not None
        told.says += self._lastly.says(self._end, self._origin, known)
        ends = f"The recording ends {clock(self._end)}, in {self._state or 'no state'}"
        told.says.append(f"{ends}{self._extremes.at_last}.")
        yield Chapter("What happened", tuple(told.says))
        yield from self._tables()

    @property
    def _origin(self) -> Position | None:
        standing = self._derivation.standing if self._derivation else None
        return standing.origin if standing else None

    @property
    def home(self) -> Position | None:
        """The point that the next recording's distances count from if the program only restarts."""
        return self._lastly.home(self._origin)

    @property
    def _under_way(self) -> bool:
        """Whether a leg was flown or an emergency occurred; also True if that is not known."""
        unknown = self._unsaid.lost and not self._state
        return unknown or bool(self._told.legs) or self._state.startswith(EMERGENCY)

    def spells(self) -> Sequence[Spell]:
        """Return when which sensor could not be believed."""
        return self._doubts.spells(self._end) if self._doubts else ()

    def _never_flown(self) -> Iterator[str]:
        if self._flown is None:
            return
        legs = [s.path for s in self._flown.states if s.leg and s.path != IMPLICIT_SURFACE]
        flown = {leg.path for leg in self._told.legs}
        never = [path.partition("/")[2] for path in legs if path not in flown]
        if never:
            yield f"Legs of the mission that were never flown: {', '.join(never)}."

    def _tables(self) -> Iterator[Chapter]:
        told = self._told
        yield from tabled(
            [leg.row(self._end) for leg in told.legs],
            [least.row(name) for name, least in told.least.items()],
            summed(self.spells()),
            told.alarms.told(),
            told.words.rows(),
            told.refusals.rows(),
            told.commands.rows(),
        )
