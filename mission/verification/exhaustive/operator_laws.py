"""Laws of the operator's side: what is accepted when, what is answered to whom, what is relayed.

What does not live here: X, W and M, and the states that commands lead to (laws).
"""

from __future__ import annotations

from mission.model import (
    AUTONOMOUS,
    IDLE_EMPTY,
    IDLE_READY,
    MANUAL_DRIVING,
    STOPPED,
    SURFACED,
)
from mission.model.alarms import mask_of
from mission.verification.exhaustive.cell import Cell
from mission.verification.exhaustive.commands import COPIED, WORD
from mission.verification.exhaustive.laws import (
    AT_SURFACE,
    DEEP_REST,
    STICK_QUIET,
    Law,
    Verdict,
    wrong,
)
from mission.verification.exhaustive.lines import ANSWERS, WATER, X
from protocol.operator_words import WORDS
from protocol.state_frame import MOST, STATES

FRESH_FIX = 5.0  # s (R9)
COPY_OF = 65000.0  # m
_NOW = 1e-6  # s


def _ack(cell: Cell, code: str, accepted: bool) -> str:
    """Return what is wrong with the acknowledgement, which leaves on the path of its request."""
    letter = code[1:].encode() if accepted else b"N"
    wanted = b"@ACK_" + code.encode() + letter + b"$"
    at = {"tender": "tender", "modem": ""}.get(cell.event.path, "boat")
    found = [t for t in cell.answers(b"@ACK_" + code.encode()) if t.address == at]
    return wrong((not found, "no answer"), (wanted not in found[-1].data if found else False,
                   f"{found[-1:]}, not {wanted!r}"))  # fmt: skip


def _line(cell: Cell) -> Verdict:
    """R3: lines are accepted only in idle, and a line out of place not even there."""
    if cell.event.command != "AW":
        return None
    idle = cell.configuration.region == "idle"
    taken = idle and cell.event.path != "misplaced"
    return _ack(cell, "AW", taken) or wrong(
        (not idle and cell.state.partition("/")[0] == "idle" and len(cell.states) > 1, "idle"),
        (cell.event.path == "whole" and idle and cell.state != IDLE_READY, "it is not ready"),
    )


def _may_start(cell: Cell) -> bool:
    c = cell.configuration
    if c.region == "autonomous":
        return cell.event.path == "boat"
    if cell.event.path != "boat" or not (c.auto and c.loaded) or c.region == "emergency":
        return False
    if c.region == "manual" and (cell.before.stick_age < STICK_QUIET or c.preceded):
        return False
    return _placed(cell)


def _placed(cell: Cell) -> bool:
    """Whether depth and fix allow a start (R7, R9)."""
    if cell.configuration.leaf:
        return True
    free, depth = cell.chart.mission.start_without_fix, cell.before.depth
    return depth < DEEP_REST if free else depth < AT_SURFACE and cell.before.fix_age <= FRESH_FIX


def _start(cell: Cell) -> Verdict:
    """@AA starts from idle with a fix and from manual 2 s after the stick; never out of an
    emergency, with AUTO closed or with lines missing. While a mission runs: Y, and no effect."""
    if cell.event.command != "AA" or cell.event.path == "after the stick":
        return None
    c, accepted = cell.configuration, _may_start(cell)
    if cell.event.path == "staging" and c.region != "idle":
        accepted = _may_start_now(cell)
    fault = _ack(cell, "AA", accepted)
    after = cell.world.at_once if cell.event.path != "staging" else cell.states[-1]
    if fault or cell.event.path == "staging":
        return fault
    if not accepted or c.region == "autonomous":
        return wrong((after != c.state, f"the state is {after}"))
    leg = c.leaf or cell.chart.initial
    return wrong((after != leg, f"the state is {after}, not {leg}"))


def _may_start_now(cell: Cell) -> bool:
    """Whether @AA right after a line is accepted. Outside idle no line is, so none is missing."""
    c = cell.configuration
    if c.region == "autonomous":
        return True
    ready = c.auto and c.loaded and c.region == "manual" and not c.preceded
    return ready and cell.before.stick_age >= STICK_QUIET and _placed(cell)


def _no_restart(cell: Cell) -> Verdict:
    """@AA while a mission runs does not start it again."""
    if cell.event.command != "AA" or cell.configuration.region != "autonomous":
        return None
    if not cell.configuration.quiet or cell.event.path == "after the stick":
        return None
    started = [s for s in cell.steps if s.trigger == "start"]
    return wrong((bool(started), "it was started again"))


def _clear(cell: Cell) -> Verdict:
    """@AC is accepted in idle; in stopped and surfaced at the surface, or when it is repeated and
    no depth over 2 m is believed; elsewhere N."""
    if cell.event.command != "AC":
        return None
    state = cell.states[-2] if len(cell.states) > 1 else cell.configuration.state
    state = state if cell.state == IDLE_EMPTY else cell.state
    may = state in (IDLE_EMPTY, IDLE_READY, STOPPED, SURFACED)
    if state in (STOPPED, SURFACED):
        known, again = cell.event.sensor != "depth", cell.event.path == "again"
        at_surface = known and cell.world.sea.depth < AT_SURFACE
        may = at_surface or (again and not (known and cell.world.sea.depth > DEEP_REST))
    may = may and cell.event.path in ("boat", "again")
    cleared = cell.state == IDLE_EMPTY and not cell.world.store.content.lines
    held = cell.configuration.loaded and not cell.world.store.content.lines
    return _ack_of_anyone(cell, may) or wrong(
        (may and not cleared, f"not cleared: {cell.state}"),
        (not may and held, "the mission is gone"),
    )


def _ack_of_anyone(cell: Cell, accepted: bool) -> str:
    wanted = b"@ACK_ACC$" if accepted else b"@ACK_ACN$"
    found = cell.answers(b"@ACK_AC")
    return wrong((not found or wanted not in found[-1].data, f"{found}, not {wanted!r}"))


def _clock(cell: Cell) -> Verdict:
    """@ST is accepted only in idle, and never over the modem (R10)."""
    if cell.event.command != "ST":
        return None
    idle = cell.configuration.region == "idle"
    return _ack(cell, "ST", idle and cell.event.path == "boat")


def _safety(cell: Cell) -> Verdict:
    """@SP is always accepted, and durable; with a wrong number of fields there is no answer
    (E-V2)."""
    if cell.event.command != "SP":
        return None
    if cell.event.path == "broken":
        return wrong((bool(cell.answers(b"@ACK_SP")), "answered"))
    kept = cell.world.store.content.limits
    told = any(v is not None for v in (kept.radius, kept.time, kept.depth, kept.voltage))
    return _ack(cell, "SP", True) or wrong((not told, "it is not stored"))


def _queries(cell: Cell) -> Verdict:
    """@DU, @NI, @AQ, @AE have one answer each."""
    words = {"DU": b"@VS", "NI": b"@ACK_NI", "AQ": b"@AR,", "AE": b"@AE,1,"}
    start = words.get(cell.event.command)
    if start is None:
        return None
    found = [t for t in cell.answers(start) if t.address == "boat" and t.reason == "asked"]
    return wrong((len(found) != 1, f"{len(found)} answers"))


def _other_words(cell: Cell) -> Verdict:
    """A command without a law of its own has one answer to whoever asked, whatever the state: its
    acknowledgement if it has one, else its report."""
    if cell.event.path != WORD:
        return None
    word = next(word for word in WORDS.values() if word.code == cell.event.command)
    answers = [t for t in cell.answers(b"@") if t.address == "boat"]
    code = word.code.encode()
    if word.letter:
        possible = tuple(b"@ACK_%b%b$" % (code, letter.encode()) for letter in (word.letter, "N"))
        found = [t for t in answers if t.data.startswith(possible)]
    else:
        found = [t for t in answers if t.reason == "asked"]
    return wrong((len(found) != 1, f"{len(found)} answers to @{word.code}"))


def _state_of_store(cell: Cell) -> Verdict:
    if cell.event.command != "AQ":
        return None
    idle, loaded = cell.configuration.region == "idle", cell.configuration.loaded
    wanted = b"running" if not idle else b"ready" if loaded else b"empty"
    found = cell.answers(b"@AR,")
    return wrong((not found or not found[0].data.startswith(b"@AR," + wanted), f"{found}"))


def _state_of_vehicle(cell: Cell) -> Verdict:
    """@AE has the present state, and an emergency as an alarm, too, in at most 64 bytes."""
    found = cell.answers(b"@AE,1,")
    if cell.event.command != "AE" or not found:
        return None
    fields = found[0].data.decode().split(",")
    told, alarms = STATES[fields[2]], int(fields[-4], 16)
    wanted = AUTONOMOUS if cell.state.startswith(AUTONOMOUS) else cell.state
    alarmed = bool(alarms & mask_of(["emergency"]))
    return wrong(
        (len(cell.states) == 1 and told != wanted, f"{told}, not {wanted}"),
        (alarmed != told.startswith("emergency/"), f"{told} with the alarms {alarms:x}"),
        (len(found[0].data) > MOST, f"{len(found[0].data)} bytes"),
    )


def _relays(cell: Cell) -> Verdict:
    """R and rudder frames of the commander reach the STM32 once, whatever the state; boards of
    other documents have no frame for them (R12, R14)."""
    frames = {"RS": b"@RSCOOCCC", "RI": b"@RI$", "D": b"@D"}
    start = frames.get(cell.event.command)
    if start is None:
        return None
    found = cell.frames(start)
    moved = len(cell.states) > 1 and cell.states[1] == MANUAL_DRIVING
    wanted = 0 if cell.event.path == "tender" or ANSWERS not in cell.line.has else 1
    return wrong((len(found) != wanted, f"{len(found)} left"), (moved, "manual"))


def _not_theirs(cell: Cell) -> Verdict:
    """Of the Z class only X0 and WF are the operator's; others are not taken for them (E-V15)."""
    if cell.event.command != "Z":
        return None
    strange = [t for t in cell.frames() if t.data in (b"@ZAF11$", b"@ZAS77$", b"@ZAX1$", b"@ZAW0$")]
    return wrong(
        (bool(strange), f"{strange[:1]} was passed on"),
        (cell.world.at_once != cell.configuration.state, f"now {cell.world.at_once}"),
    )


def _nodes(cell: Cell) -> Verdict:
    """R13: closing AUTO ends a mission, also an interrupted one; STM32 closes only in idle, the Pi
    never; N if a node does not change within 5 s."""
    if cell.event.command != "NS":
        return None
    c = cell.configuration
    if cell.event.path == "unanswered":
        return _ack(cell, "NS", False)
    if cell.event.path in ("open", "uacm", "camera", "pi"):
        return _ack(cell, "NS", True)
    if cell.event.path == "stm32":
        if c.region == "idle":
            return None
        return _ack(cell, "NS", False)
    if c.region == "autonomous":
        return wrong(
            (cell.world.at_once != IDLE_READY, f"the state is {cell.world.at_once}"),
            (X not in [t.data for t in cell.frames(b"@ZA")][:1], "X0 is not the first to leave"),
        )
    return wrong((cell.world.at_once != c.state, f"the state is {cell.world.at_once}"))


def _paths(cell: Cell) -> Verdict:
    """R12: an answer leaves only on the path of its request."""
    answers = [t for t in cell.answers(b"@ACK_") if b"@ACK_Z" not in t.data]
    if not answers:
        return None
    paths = {"tender": {"tender", "boat"}, "modem": {""}, "both": {"boat", ""}}
    allowed = paths.get(cell.event.path, {"boat"})
    if cell.event.name == "AC of another, the boat silent":
        allowed = {"tender"}
    strange = [t for t in answers if t.address not in allowed]
    return wrong((bool(strange), f"{strange[:1]}"))


def _others_read(cell: Cell) -> Verdict:
    """R12: a connection that does not command changes nothing, except by X and W."""
    if cell.event.path != "tender" or cell.event.command in ("X", "W"):
        return None
    return wrong((cell.world.at_once != cell.configuration.state, f"now {cell.world.at_once}"))


def _tells_at_surface(cell: Cell) -> Verdict:
    """R11: at the surface one unasked @VS leaves on every path."""
    if "restart" in cell.event.causes:  # nobody is connected yet
        return None
    if (
        SURFACED not in cell.states[1:]
        or cell.state != SURFACED
        or cell.world.sea.depth >= cell.world.deep
    ):
        return None
    told = [t for t in cell.answers(b"@VS") if t.reason != "asked" and t.address]
    each = sorted(t.address for t in told)
    return wrong((each != ["boat", "tender"], f"told {each}"))


def _not_told_below(cell: Cell) -> Verdict:
    """R11: no unasked @VS leaves below the surface, whatever a receiver sends there."""
    told = [t for t in cell.answers(b"@VS") if t.reason == "at the surface"]
    if not told or "depth" in cell.world.sea.unknown:
        return None
    deep = min(cell.before.depth, cell.world.sea.depth)
    return wrong((deep > 2.0 * AT_SURFACE, f"told {deep:.1f} m deep, in {cell.state}"))


def _stays_up(cell: Cell) -> Verdict:
    """@AA resumes no mission in manual with AUTO closed (R13), nor after an emergency (R6)."""
    c = cell.configuration
    if c.region not in ("manual", "emergency") or "AA" not in cell.event.causes:
        return None
    if c.auto and not c.preceded:
        return None
    return wrong((cell.region == "autonomous", f"the state is {cell.state}"))


def _copies(cell: Cell) -> Verdict:
    """R12: a copy by modem starts nothing and loosens no limit; it is answered as done if what it
    asks for is in force."""
    if "copy" not in cell.event.causes:
        return None
    told = [t for t in cell.answers(b"@ACK_") if not t.address]
    if "SP" in cell.event.causes:
        kept = cell.world.store.content.limits.radius
        return wrong((kept == COPY_OF, "loosened"), (b"SPN" not in told[-1].data, f"{told}"))
    arrived = cell.before.t + COPIED
    runs = [s for t, s in cell.world.states if t <= arrived][-1].startswith("autonomous")
    wanted = b"@ACK_AAA$" if runs else b"@ACK_AAN$"
    started = [s for s in cell.steps if s.trigger == "start" and s.t >= arrived - _NOW]
    return wrong(
        (bool(started), "a copy started it"),
        (not told or wanted not in told[-1].data, f"{told}, not {wanted!r}"),
    )


OPERATOR_LAWS: tuple[Law, ...] = (
    Law("@AW only in idle", "R3", _line),
    Law("@AA by state", "R3, R6, R7, R9, R13", _start),
    Law("@AA while it runs has no effect", "R1", _no_restart),
    Law("@AC by state", "R7", _clear),
    Law("@ST only in idle, not by modem", "R10", _clock),
    Law("@SP always, and durable", "R5", _safety),
    Law("one answer to a question", "R4, R11, R13", _queries),
    Law("a word without a law of its own is answered once", "R1, R12", _other_words),
    Law("@AQ tells the store's state", "R4", _state_of_store),
    Law("@AE tells the state, and an emergency", "R4", _state_of_vehicle),
    Law("R and rudder frames are passed on once", "R12, R14", _relays),
    Law("no other Z of an operator's does anything", "R7, E-V15", _not_theirs),
    Law("@NS by state", "R13", _nodes),
    Law("an answer leaves on the path of its request", "R12", _paths),
    Law("who does not command only reads", "R12", _others_read),
    Law("a late copy does nothing that is not in force", "R1, R12", _copies),
    Law("one @VS unasked at the surface", "R11", _tells_at_surface),
    Law("no @VS unasked below it", "R11", _not_told_below, needs=frozenset({WATER})),
    Law("no mission out of an emergency or with AUTO closed", "R6, R13", _stays_up),
)
