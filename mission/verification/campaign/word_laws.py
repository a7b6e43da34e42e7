"""Laws of commands and moves over the whole flight: who may do what, and what must have left.

    clock      a leg lasts no longer than its clock allows
    stop       an X0 is repeated until it is acknowledged, and where a report shows a thruster on
    restart    a vehicle that was under way surfaces; an emergency that had ended is latched
    end        told to end, the program first brings up a vehicle that is under way
    stick      no stick that is held, and none in neutral, takes an emergency over (R6); after 2 s
               without M everything is stopped, and a minute later manual is left
    commander  one connection commands while its frames are received (R12)
    AUTO       closed: no mission continues or begins, nothing turns by itself or is held up (R13)
    gap        20 ms between two frames on the line
    refused    a set that is answered N: the leg's else (refusal_laws)
    blind      a leg that needs a failed reading is left within 6 s of the failure being known

What does not live here: who asked for a byte (audit), an X, W or set in time (obedience), what
holds at the surface alone (surface_laws).
"""

from __future__ import annotations

import functools
import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import digest, parse, script
from mission.model import (
    IMPLICIT_SURFACE,
    MANUAL_DRIVING,
    MANUAL_WAITING,
    STOPPED,
    SURFACED,
    SURFACING,
    Step,
    Tx,
)
from mission.model.regions import EMERGENCY, MANUAL
from mission.verification.campaign.audit import commands_of
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.refusal_laws import heeds_refusals
from mission.verification.campaign.reports import Report
from mission.verification.campaign.stick_laws import M, lets_go, takes_over
from mission.verification.campaign.story import SAME, STOP_WORD, Stay, Story
from mission.verification.campaign.surface_laws import UNLAWFUL, UNSENT
from mission.verification.campaign.trial import AUTO_NODE, fault_ends
from mission.verification.rig.acts import MODEM, TOPSIDE, Act
from mission.verification.rig.line import crowded
from mission.verification.rig.program import DEAD
from mission.verification.rig.trace import Done, Said
from mission.verification.rig.vehicle import flown
from protocol.messages import FrameFault, Order
from protocol.topside import TopsideCodec

_CLOCK = 0.6  # s
_STOP_AGAIN = 1.6  # s: every 0.5 s, after three tries of another command
_TURNS = 1  # report with a thruster on: X0 leaves after it
_UPWARD = 2.0  # s after a restart
_DEEP_ENOUGH, _STAYS = 1.5, 100.0  # m, s: an ascent from the depth of the scenes
_UP = 0.5  # m: a port that clogs above it shows the surface for ever
_RISES = 0.5  # m in 5 s: let go, the vehicle floats up
_LEFT = 2.5  # m: 2 (R7, an orderly end), and the sensor
_DURABLE = 1.5  # s after which a state is on disk
_BLIND, _FROZEN = 14.0, 12.0  # s: 6 s (R8), and the time of three more reports
_COMMANDS = 9.5  # s
_COPY = 125.0  # s for which a command is a copy of one by modem, with time for its answer
_RELAYED = 2.0  # s from a command to the answer of its relay
_ACKNOWLEDGED = re.compile(rb"@ACK_Z[XA]Y\$")
_ACCEPTED = re.compile(rb"@ACK_(?:(?:AA|AC|SP|ST|AW|NS|RS)[^N]|RI.)\$", re.DOTALL)
_NODE, _LET_GO = 1.0, 1.0  # s
_ORDER = re.compile(rb"@ZA(X0|WF)\$")
_ENDS_AT_ONCE = (Act.HURRY, Act.DIE_BEFORE, Act.DIE_AFTER)


def word_laws(story: Story) -> Iterator[Violation]:
    text = "\n".join(script(story.mission)) + "\n"
    clocks = _clocks(text, story.mission.vehicle)
    for stay in story.stays:
        if stay.autonomous:
            yield from _ends_in_time(story, stay, clocks)
            yield from _is_left_blind(story, stay)
        if stay.rests and stay.step is not None:
            yield from _stops(story, stay)
        if stay.state == MANUAL_DRIVING and stay.before.startswith(EMERGENCY):
            yield from takes_over(story, stay)
        if stay.state.startswith(MANUAL):
            yield from lets_go(story, stay)
        if stay.before == DEAD:
            yield from _begins_again(story, stay)
    yield from _one_commands(story)
    yield from _ends_on_its_way_up(story)
    yield from _auto_closed(story)
    yield from _keeps_the_gap(story)
    yield from heeds_refusals(story)


# --- legs ----------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=64)
def _clocks(text: str, vehicle: str) -> Mapping[str, float]:
    """Return the longest stay in each leg, s."""
    mission = parse(text)
    chart = compile_mission(mission, flown(vehicle), digest(mission))
    legs = {state.path: state.leg for state in chart.states if state.leg is not None}
    return {
        path: min(leg.duration or math.inf, leg.timeout or math.inf)
        for path, leg in legs.items()
        if path != IMPLICIT_SURFACE
    }


def _ends_in_time(story: Story, stay: Stay, clocks: Mapping[str, float]) -> Iterator[Violation]:
    due = stay.begin + clocks.get(stay.state, math.inf)
    if stay.end > due + _CLOCK and not story.hindered(due - 0.1, due + _CLOCK):
        says = (
            f"{stay.end - stay.begin:.0f} s in {stay.state}, its clock says {due - stay.begin:g} s"
        )
        yield Violation(UNLAWFUL, due, says)


def _is_left_blind(story: Story, stay: Stay) -> Iterator[Violation]:
    """A leg without a reading that it needs is left.

    A frozen reading is known by five reports while a thruster turns, and so is a heading at full
    scale.
    """
    commands = commands_of(stay.step) if stay.step is not None else []
    if not commands or stay.ascends:
        return
    command = commands[-1]
    for fault in story.settings.faults:
        sensor, _, how = fault.name.partition("_")
        needed = not isinstance(command, Order) and getattr(command, sensor, None) is not None
        if not needed or how not in ("full_scale", "frozen"):
            continue
        begin = max(fault.begin, stay.begin)
        due = begin + _BLIND + _FROZEN
        turned = all(r.may_turn for r in story.reports if begin - 2.0 <= r.t <= due)
        told = len(story.told_in(begin, due)) >= (due - begin) / 2.0 - 2.0
        alone = len(story.faults((sensor,), fault.begin - 10.0, due)) == 1  # one's end ends both
        known = turned and told and alone and not story.hindered(begin, due)
        if known and min(stay.end, fault_ends(fault)) > due:
            yield Violation(UNLAWFUL, due, f"{fault.name}, and still in {stay.state}")


# --- stops ---------------------------------------------------------------------------------------


def _stops(story: Story, stay: Stay) -> Iterator[Violation]:
    assert stay.step is not None
    if not any(a.startswith("everything stopped") for a in stay.step.actions):
        return
    end = min(stay.end, story.end)
    if story.hindered(stay.begin - 0.1, end):
        return
    stops = [w.t for w in story.words_in(stay.begin, end) if w.data == STOP_WORD]
    answered = next(
        (h.t for h in story.heard if h.t > stay.begin and _ACKNOWLEDGED.search(h.data)), end
    )
    last = stay.begin
    for t in [*(t for t in stops if t < answered), min(answered, end)]:
        if t - last > _STOP_AGAIN:
            yield Violation(UNSENT, t, f"no X0 for {t - last:.1f} s in {stay.state}, unanswered")
            return
        last = t
    yield from _doubts(story, stay, stops, end)


def _doubts(story: Story, stay: Stay, stops: list[float], end: float) -> Iterator[Violation]:
    turning: list[Report] = []
    for report in story.reports:
        if not stay.begin + 2.0 < report.t < end:
            continue
        turning = [*turning, report] if report.turning else []
        if len(turning) > _TURNS and not any(turning[0].t <= t <= report.t for t in stops):
            says = f"a thruster is on in {len(turning)} reports in {stay.state}: no X0"
            yield Violation(UNSENT, report.t, says)
            return


# --- the program begins again --------------------------------------------------------------------


def _begins_again(story: Story, stay: Stay) -> Iterator[Violation]:
    """A restart finds the state on disk, if it lasted long enough and the disk was not full.

    A program that dies while it writes a state may have left either state there. An operator's X
    replaces the commands that wait.
    """
    dead = next(s for s in reversed(story.stays) if s.state == DEAD and s.end <= stay.begin)
    was = next(s for s in reversed(story.stays) if s.end <= dead.begin and s.state != DEAD)
    full = any(done.act is Act.FILL and done.t < stay.begin for done in story.done)
    due = stay.begin + _UPWARD
    stops = (Act.KILL, Act.STALL)
    again = any(done.act in stops and stay.begin <= done.t <= due for done in story.done)
    orders = [_ORDER.search(s.data) for s in story.said if stay.begin <= s.t <= due]
    stopped = any(order[1] == b"X0" for order in orders if order)
    if was.end - was.begin < _DURABLE or full or again or stopped or due > story.end:
        return
    now = story.stay_at(stay.begin + 1e-6).state
    died = any(d.act in (Act.DIE_BEFORE, Act.DIE_AFTER) and d.t < stay.begin for d in story.done)
    if was.state in (STOPPED, SURFACED) and now != was.state and not died:
        yield Violation(UNLAWFUL, stay.begin, f"restarted out of {was.state} into {now}")
    if not (was.autonomous or was.state == SURFACING):
        return
    words = {word.data for word in story.words_in(stay.begin, due)}
    if story.upward and words.isdisjoint(story.upward) and now != MANUAL_DRIVING:
        says = f"no upward word within {_UPWARD:g} s of a restart during {was.state}"
        yield Violation(UNSENT, due, says)


def _ends_on_its_way_up(story: Story) -> Iterator[Violation]:
    """Told to end under way, the program brings the vehicle up, and stays until it is up (R7).

    After an X it waits for a vehicle that is deeper than 2 m.
    """
    for end in story.done:
        if end.act is not Act.END:
            continue
        stay, due = story.stay_at(end.t - SAME), end.t + _UPWARD
        under_way = stay.autonomous or stay.state == SURFACING
        deep = story.depth(end.t) > _DEEP_ENOUGH
        orders = any(end.t - 1.0 <= s.t <= due and _ORDER.search(s.data) for s in story.said)
        others = any(end.t - 10.0 <= d.t <= end.t and d is not end for d in story.done)
        if not (under_way and deep) or orders or others or due > story.end:
            continue
        ways = stay.ascends or _has_word(story, end.t - 0.1, due)
        sticks = [s.begin for s in story.stays if s.state.startswith(MANUAL)]
        taken = min((begin for begin in sticks if begin >= end.t - SAME), default=math.inf)
        if story.tilt(end.t) < 1.0 and not ways and taken > due:
            yield Violation(UNSENT, due, f"told to end in {stay.state}: no upward word")
        gone = next((d.t for d in story.done if d.act is Act.LEAVE and d.t > end.t), math.inf)
        hurried = any(done.act in _ENDS_AT_ONCE for done in story.done)
        if hurried or taken <= gone or _is_unseen(story, gone):
            continue
        if gone <= end.t + _STAYS and story.depth(gone) > _allowed(story, gone):
            says = f"told to end in {stay.state}, and gone {story.depth(gone):.1f} m deep"
            yield Violation(UNLAWFUL, gone, says)


def _allowed(story: Story, gone: float) -> float:
    """Return how deep the vehicle may be as the program ends, m.

    Where nothing brings it up, the program waits while it is deeper than 2 m (R7).
    """
    waits = story.stay_at(gone - SAME).state == STOPPED or story.auto_closed(gone - SAME, gone)
    return _LEFT if waits else _DEEP_ENOUGH


def _is_unseen(story: Story, gone: float) -> bool:
    """Whether a wrong depth has shown the surface.

    Its port clogged at the surface; or the vehicle rises with a clogged port; or it rises with a
    drifting depth, by a thrust that stays.
    """
    rises = story.depth(gone - 5.0) - story.depth(gone) > _RISES
    clogged = story.faults(("depth_stuck",), gone, gone)
    there = any(story.depth(fault.begin) < _UP for fault in clogged)
    drifts = story.faulty(("depth_drifting",), gone, gone)
    words = story.words_in(gone - 60.0, gone)
    pushed = bool(words) and words[-1].data in story.upward
    return there or (rises and (bool(clogged) or (drifts and pushed)))


def _has_word(story: Story, begin: float, end: float) -> bool:
    return any(word.data in story.upward for word in story.words_in(begin, end))


# --- operators -----------------------------------------------------------------------------------


def _one_commands(story: Story) -> Iterator[Violation]:
    """Only the connection whose command was acknowledged last gets commands acknowledged.

    X and W hand the command over. So does an M, which is not acknowledged, when it takes the stick.
    A connection without whole frames counts as silent. The time of sending counts: a relay is
    answered later.
    """
    commander, heard = "", -math.inf
    stick: Said | None = None  # the last M of another connection that may take over
    free: dict[str, float] = {}  # when each other one last sent an allowed command
    streams: defaultdict[str, TopsideCodec] = defaultdict(TopsideCodec)
    by_modem: dict[bytes, float] = {}  # answers, and when each last went there
    for event in story.trial.events:
        if isinstance(event, Said):
            if event.link == TOPSIDE and _ORDER.search(event.data):
                free[commander] = heard  # until now: its requests are answered after that
                commander = event.address
            if event.link == MODEM:
                commander = ""  # the commander by modem is not known here
            elif _has_frame(streams[event.address], event):
                if event.address == commander:
                    heard = event.t
                elif event.t - heard >= _COMMANDS:
                    free[event.address] = event.t
                    stick = event if M.search(event.data) else stick
        elif isinstance(event, Step):
            if event.entered[-1:] == (MANUAL_DRIVING,) and stick and stick.t > event.t - SAME:
                commander, heard, stick = stick.address, stick.t, None
        elif isinstance(event, Tx) and (accepted := _ACCEPTED.search(event.data)):
            if event.link == MODEM:
                by_modem[accepted[0]] = event.t
            other = commander and event.address != commander and event.t - heard < _COMMANDS
            # Asked before an X or W of another: it does not get the command back.
            relayed = other and event.t - free.get(event.address, -math.inf) <= _RELAYED
            copied = event.t - by_modem.get(accepted[0], -math.inf) < _COPY
            if event.link != TOPSIDE or relayed or copied:
                continue  # R12: a copy of a command by modem is answered as done
            if other and not story.hindered(event.t - _COMMANDS, event.t):
                says = f"{event.data!r} to {event.address!r} while {commander!r} commands"
                yield Violation(UNLAWFUL, event.t, says)
            commander, heard = event.address, event.t
        elif isinstance(event, Done) and event.act in (Act.PART, Act.KILL):
            commander = ""


def _has_frame(stream: TopsideCodec, said: Said) -> bool:
    """Whether the bytes complete a frame. An unfinished one before may be given up now."""
    due = stream.next_timer()
    given_up = stream.flush(said.t) if due is not None and due <= said.t else []
    found = [*given_up, *stream.receive(said.data, said.t)]
    return not all(isinstance(one, FrameFault) for one in found)


def _auto_closed(story: Story) -> Iterator[Violation]:
    """Judge from the acknowledged closing of AUTO until somebody opens it."""
    for said in story.said:
        found = AUTO_NODE.fullmatch(said.data)
        if found is None or found[1] == b"O":
            continue
        answers = (a.t for a in story.answers if a.t >= said.t and a.data == b"@ACK_NSS$")
        closed = next(answers, math.inf) + _NODE
        others = (s.t for s in story.said if s.t > said.t and b"@NS" in s.data)
        until = min(next(others, math.inf), *(d.t for d in story.done if d.t > said.t), story.end)
        if closed > said.t + 6.0 + _NODE or closed >= until:
            continue
        for stay in story.stays:
            inside = max(stay.begin, closed) < min(stay.end, until)
            turned = stay.state == SURFACING and stay.begin >= closed and _at_rest(stay.before)
            if inside and (stay.autonomous or (turned and _by_limit(stay))):
                yield Violation(UNLAWFUL, closed, f"node AUTO is closed, and then {stay.state}")
                return
            if inside and stay.state == SURFACED:
                yield from _is_let_go(story, max(stay.begin, closed), min(stay.end, until))


def _is_let_go(story: Story, begin: float, end: float) -> Iterator[Violation]:
    """The last command before AUTO is closed is a stop, and only stops follow."""
    if story.board is not None or story.hindered(begin - _LET_GO, end):
        return
    orders = [w for w in story.words_in(0.0, end - 2.0 * SAME) if w.data.startswith(b"@ZA")]
    before = sum(w.t <= begin + _LET_GO for w in orders)
    if others := [w.data for w in orders[max(before - 1, 0) :] if w.data != STOP_WORD]:
        says = f"node AUTO is closed, and in {SURFACED} {others[0]!r}"
        yield Violation(UNLAWFUL, begin, says)


def _at_rest(state: str) -> bool:
    return state.startswith("idle") or state in (STOPPED, SURFACED, MANUAL_WAITING)


def _by_limit(stay: Stay) -> bool:
    """Whether a limit or a forgotten stick led here."""
    return stay.step is not None and stay.step.trigger in ("limit", "forgotten")


# --- the line ------------------------------------------------------------------------------------


def _keeps_the_gap(story: Story) -> Iterator[Violation]:
    if story.board is None and (found := crowded(story.words)):
        yield Violation(UNLAWFUL, *found)
