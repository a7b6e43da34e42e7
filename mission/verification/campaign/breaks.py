"""Ways to break a rule that need more than another value.

What does not live here: which rule each one breaks (broken), how it is put back (surgery).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mission.engine import core, ending, monitor, orders, state
from mission.engine.ascent import Ascent
from mission.engine.bounds import Bounds, in_force
from mission.engine.core import Core
from mission.engine.engine import Engine
from mission.engine.limits import LIMITS
from mission.engine.rest import Rest
from mission.engine.run import Run
from mission.engine.vehicle_state import VehicleState
from mission.model import Action, By, Edge, Health, Outcome, Result, Safety, Tx
from mission.model.vehicle import Vehicle
from mission.navigation.belief import DepthBelief
from mission.navigation.fixes import FIX_DEPTH, Receiver
from mission.navigation.health import SensorHealth
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.repeater import Repeater
from mission.onboard.runtime.resume_marker import ResumeMarker
from mission.verification.campaign.surgery import (
    Break,
    Surgery,
    instead,
)
from protocol.messages import Fix, Order, SetSafety
from protocol.vehicles import vehicle_row


def never_acts(name: str) -> Break:
    others = {each: row for each, row in LIMITS.items() if each != name}
    return lambda s: s.put(monitor, "LIMITS", others)


def without_way(way: Any) -> Break:
    honest = vehicle_row

    def fewer(codec: str) -> Any:
        row = honest(codec)
        return replace(row, ways=tuple(w for w in row.ways if w != way))

    return instead(state, "vehicle_row", fewer)


def sensor_is_healthy(sensor: str) -> Break:
    honest = SensorHealth.of

    def of(self: SensorHealth, name: str, now: float) -> Health:
        return Health(True, "", 0.0) if name == sensor else honest(self, name, now)

    return instead(SensorHealth, "of", of)


def restart_only_stops(surgery: Surgery) -> None:
    honest = Core.surface

    def surface(self: Core, name: str, why: str, by: By, *rest: Any, **more: Any) -> None:
        if name == "restart":
            self.stop_quietly(why)
        else:
            honest(self, name, why, by, *rest, **more)

    surgery.put(Core, "surface", surface)


def marker_not_kept(surgery: Surgery) -> None:
    surgery.put(ResumeMarker, "follow", lambda self, under_way, now: None)
    surgery.put(ResumeMarker, "foresee", lambda self, leaf: "")


def relays_first(surgery: Surgery) -> None:
    honest = Frontseat.next_out

    def relays_before(self: Frontseat, now: float) -> list[Tx]:
        return [self._transmit(*self._relays.take(), now)] if self._relays else honest(self, now)

    surgery.put(Frontseat, "next_out", relays_before)


def relays_between_tries(surgery: Surgery) -> None:
    honest = Frontseat.next_out

    def relays_too(self: Frontseat, now: float) -> list[Tx]:
        if out := honest(self, now):
            return out
        return [self._transmit(*self._relays.take(), now)] if self._relays else []

    surgery.put(Frontseat, "next_out", relays_too)


def has_relays(self: Frontseat, now: float) -> bool:
    return bool(self._relays)


def turns_with_auto_closed(surgery: Surgery) -> None:
    honest = Core.mind_rest

    def mind_rest(self: Core) -> None:
        known, self.auto = self.auto, True
        honest(self)
        self.auto = known

    surgery.put(Core, "mind_rest", mind_rest)


def starts_anywhere(surgery: Surgery) -> None:
    honest = orders.why_not_fly

    def why_not_fly(*given: Any) -> str:
        why = honest(*given)
        return "" if why.endswith("a mission starts at the surface") else why

    surgery.put(orders, "why_not_fly", why_not_fly)


def starts_with_auto_closed(surgery: Surgery) -> None:
    honest = orders.why_not_start

    def why_not_start(of: Core) -> str:
        why = honest(of)
        return "" if why == "node AUTO is closed" else why

    surgery.put(orders, "why_not_start", why_not_start)


def clears_anywhere(surgery: Surgery) -> None:
    surgery.put(orders, "_at_surface", lambda of: True)


def loosest(surgery: Surgery) -> None:
    def without(vehicle: Vehicle, mission: Safety | None, operator: SetSafety) -> Bounds:
        return in_force(vehicle, mission, SetSafety())

    surgery.put(core, "in_force", without)


def legs_for_ever(surgery: Surgery) -> None:
    honest = Run.due

    def due(self: Run, edge: Edge, known: VehicleState) -> float | None:
        return None if edge.by in (By.FOR, By.TIMEOUT) else honest(self, edge, known)

    surgery.put(Run, "due", due)


def refusals_accepted(surgery: Surgery) -> None:
    honest = Core.take_outcome

    def take(self: Core, outcome: Outcome) -> None:
        accepted = outcome.result is Result.REFUSED
        honest(self, replace(outcome, result=Result.ACCEPTED) if accepted else outcome)

    surgery.put(Core, "take_outcome", take)


def stop_every_five_seconds(surgery: Surgery) -> None:
    honest = Frontseat.poll

    def poll(self: Frontseat, now: float) -> tuple[list[Tx], list[Outcome]]:
        sent, outcomes = honest(self, now)
        due = not sent and now >= self._free and int(now) % 5 == 0
        return ([*sent, Tx(now, "vehicle", b"@ZAX0$", "every 5 s")] if due else sent), outcomes

    surgery.put(Frontseat, "poll", poll)
    repeated = Repeater.poll

    def stopped(self: Repeater, now: float) -> tuple[list[Tx], list[Outcome]]:
        sent, outcomes = repeated(self, now)
        if not sent or int(now) % 5:
            return sent, outcomes
        frames = self._encode(Order.STOP)
        return [Tx(now, "vehicle", frame, "every 5 s") for frame in frames], outcomes

    surgery.put(Repeater, "poll", stopped)


def half_the_pace(surgery: Surgery) -> None:
    honest = Repeater.poll

    def poll(self: Repeater, now: float) -> tuple[list[Tx], list[Outcome]]:
        said = honest(self, now)
        if said[0]:
            self._due += self._period
        return said

    surgery.put(Repeater, "poll", poll)


def every_place_is_news(surgery: Surgery) -> None:
    honest = Receiver.take

    def take(self: Receiver, fix: Fix) -> None:
        honest(self, fix)
        self.fresh = True

    surgery.put(Receiver, "take", take)


def no_contradiction(surgery: Surgery) -> None:
    surgery.put(DepthBelief, "_contradict", lambda self, t, why, *, moves: None)


def fixes_count_against_movement(surgery: Surgery) -> None:
    honest = surgery.found(DepthBelief, "_floats")

    def floats(self: DepthBelief, t: float, moved: float, receiver: Receiver) -> bool:
        return bool(honest(self, t, 0.0, receiver))

    surgery.put(DepthBelief, "_floats", floats)


def fixes_explain_what_stands(surgery: Surgery) -> None:
    honest = surgery.found(DepthBelief, "_notice")

    def notice(self: DepthBelief, t: float, depth: float, *given: Any) -> None:
        honest(self, t, depth, *given)
        if depth < FIX_DEPTH and t - given[-1].last_at <= 3.0:
            self._pushed_at = t

    surgery.put(DepthBelief, "_notice", notice)


def pushes_in_the_dark(surgery: Surgery) -> None:
    honest = surgery.found(Ascent, "_may_lift")

    def may_lift(self: Ascent, way: Any, depth: float | None) -> bool:
        return depth is None or honest(self, way, depth)

    surgery.put(Ascent, "_may_lift", may_lift)


def forgets_depths(surgery: Surgery) -> None:
    honest = surgery.found(Rest, "take")

    def take(self: Rest, t: float, depth: float | None, *deep: float) -> None:
        if depth is None:
            self.begin()
        honest(self, t, depth, *deep)

    surgery.put(Rest, "take", take)


def ends_at_once(surgery: Surgery) -> None:
    """End the program at once, with an X0 as every stop, and without waiting for the surface."""
    surgery.put(ending, "go_on", lambda of: None)
    surgery.put(ending, "begin", lambda of, order: of.stop_quietly("the program is ended"))
    surgery.put(ending, "settled", lambda of: True)
    surgery.put(Engine, "settled", property(lambda self: True))


def ascent_never_changes(surgery: Surgery) -> None:
    def act(self: Ascent, now: float, *seen: Any) -> tuple[Action, ...]:
        return ()

    surgery.put(Ascent, "act", act)
