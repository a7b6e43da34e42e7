"""An operator's X and W: an order counts as done only when a report shows it. Sans-IO.

    X or W --@ACK_Z.Y--> @DU, @DU, ... until a report from after it shows
                         stop:     every thruster off
                         surface:  the surface, or a depth that has fallen by ``RISEN_M``,
                                   by @AE: a depth that its program believes, the surface proved
           --> @AQ: a contradiction that the vehicle's program itself reports

An acknowledgement proves nothing. From a board that acknowledges nothing it says only that the
order was sent (R16, R17). A report is from after the order if its time differs from that of the
first report received. The robot of document 004 reports neither thrusters nor depth to the boat:
nothing confirms its stop.

    Contradicted   (the reports show the opposite; the vehicle's program keeps sending it)
    Unconfirmed    (it was sent; no report shows that it is obeyed)

What does not live here: who waits (console), the vehicle's side (topside).
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

from mission.model import STOPPED, SURFACED, SURFACING
from mission.topside.upload import Ask, NoAnswer, OperatorError, Script, is_ack, is_report
from protocol.messages import (
    Ack,
    DataQuery,
    Emergency,
    Order,
    StateQuery,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
)
from protocol.topside import Answer

ORDER_TRIES = 10  # an order is sent until it is answered
LOOKS = {Order.STOP: 8, Order.SURFACE: 30}  # a second apart by radio
LOOKS_UNDER_WATER = {Order.STOP: 2, Order.SURFACE: 4}  # some seconds each
THRUSTERS = 5  # the first of the actuators; rudders follow
NEUTRAL = 0.02  # share of full thrust
SURFACE_M, RISEN_M, NO_DEPTH_M = 0.5, 0.5, -0.8
WORDS = {Order.STOP: "stop", Order.SURFACE: "surface"}


class Contradicted(OperatorError):
    pass


class Unconfirmed(OperatorError):
    pass


@dataclass(frozen=True, slots=True)
class Seen:
    """What reports show of an order. ``shown``: whether it is obeyed, None if they show neither.
    ``words``: a description. ``up``: the vehicle is at the surface."""

    shown: bool | None
    words: str
    up: bool = False


def order(
    which: Order, tell: Callable[[str], None] = lambda _: None, *, under_water: bool = False
) -> Script:
    """Order STOP or SURFACE. ``tell`` gets what is known before the reports are checked. Raises
    NoAnswer, Contradicted, Unconfirmed."""
    what = WORDS[which]
    answer = yield Ask(what, Emergency(which), _is_taken(which), tries=ORDER_TRIES, by_clock=True)
    if answer is None:
        raise (yield from _why_no_answer(which))
    tell(f"{what}: the vehicle has it; what its reports show is looked at now")
    looks = (LOOKS_UNDER_WATER if under_water else LOOKS)[which]
    seen = yield from _look(which, looks)
    report = yield Ask("store", StoreQuery(), is_report)
    held = report.refusal if isinstance(report, StoreReport) else ""
    if which is Order.STOP and held.startswith("X:"):
        seen = Seen(False, held.removeprefix("X:").strip())
    if seen.shown:
        return f"{what}: {seen.words}"
    if seen.shown is None:
        raise Unconfirmed(f"{what} was sent, and nothing confirms it: {seen.words}")
    raise Contradicted(f"{what} was sent, but {seen.words}; the vehicle is still told to {what}")


def _look(which: Order, looks: int) -> Generator[Ask, Answer | None, Seen]:
    """Ask for reports until one shows that the order is obeyed, at most ``looks`` times."""
    judge = _stopped if which is Order.STOP else _surfaced
    first = yield from _report()
    seen, fresh = Seen(None, "no report of the vehicle has come since"), list[Status]()
    for _ in range(looks):
        yield Ask("wait", StoreQuery(), lambda _: False, tries=1, by_clock=True)
        told = yield from _report()
        if told is None:
            continue
        first = first or told
        if told.time == first.time:
            continue
        fresh.append(told)
        seen = judge([first, *fresh])
        if seen.shown and which is Order.SURFACE:
            seen = yield from _as_believed(seen)
        if seen.shown:
            break
    return seen


def _report() -> Generator[Ask, Answer | None, Status | None]:
    answer = yield Ask("status", DataQuery(), lambda a: isinstance(a, Status))
    return answer if isinstance(answer, Status) else None


def _as_believed(seen: Seen) -> Generator[Ask, Answer | None, Seen]:
    """A depth counts only if the vehicle's program believes it. If the program reports no state (an
    older one), its report alone counts."""
    state = yield Ask("state", StateQuery(), lambda a: isinstance(a, StateReport))
    if not isinstance(state, StateReport) or state.state == SURFACED:
        return seen
    if state.to_depth_m is None:
        return Seen(None, "its program does not believe the depth that it reports; watch it")
    if seen.up and state.state == SURFACING:
        return Seen(None, "its program has not proved the surface so far; watch it")
    return seen


def _stopped(told: list[Status]) -> Seen:
    newest = told[-1].telemetry
    thrusters = newest.actuators[:THRUSTERS] if newest is not None and newest.actuators else ()
    if not thrusters:
        return Seen(None, "no thrusters are reported; watch it")
    if all(abs(share) <= NEUTRAL for share in thrusters):
        return Seen(True, "its report shows every thruster off")
    shares = " ".join(f"{100 * share:+.0f}" for share in thrusters)
    return Seen(False, f"its report still shows thrusters on ({shares} %)")


def _surfaced(told: list[Status]) -> Seen:
    depths = [s.telemetry.depth for s in told if s.telemetry and s.telemetry.depth is not None]
    now = told[-1].telemetry.depth if told[-1].telemetry else None
    if now is None:
        return Seen(None, "no depth is reported; watch it")
    if now < NO_DEPTH_M:
        return Seen(None, f"its report shows {now:.1f} m, which is no depth; watch it")
    if now < SURFACE_M:
        return Seen(True, f"its report shows {now:.1f} m: at the surface", up=True)
    if now <= max(depths) - RISEN_M:
        return Seen(True, f"it rises: {max(depths):.1f} m deep, then {now:.1f} m; watch it")
    return Seen(False, f"its depth does not fall: {depths[0]:.1f} m, now {now:.1f} m")


def _why_no_answer(which: Order) -> Generator[Ask, Answer | None, OperatorError]:
    """Return Unconfirmed if the Pi is stopped: each further X delays the ascent (R7)."""
    what = WORDS[which]
    report = yield Ask("store", StoreQuery(), is_report)
    if report is None:
        return NoAnswer(f"no answer to {what}: it is not known whether it arrived")
    why = f"the Pi has {what} and goes on sending it, but the STM32 has not acknowledged it"
    if which is Order.STOP:
        state = yield Ask("state", StateQuery(), lambda a: isinstance(a, StateReport))
        if isinstance(state, StateReport) and state.state == STOPPED:
            return Unconfirmed(why)
    return NoAnswer(why)


def _is_taken(which: Order) -> Callable[[Answer], bool]:
    """Match the order's own letter, as the Pi answers: an answer to another order may still
    arrive."""
    is_own = is_ack("Z", "X" if which is Order.STOP else "W")
    return lambda answer: is_own(answer) and isinstance(answer, Ack) and answer.ok
