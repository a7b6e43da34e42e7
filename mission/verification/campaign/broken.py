"""The campaign, tested: each safety rule broken alone, and whether its flights notice.

A row of BROKEN says how one rule is broken, in the running objects of this process and never in a
file. What a row names must exist: a rule that is written anew has its row written anew.

What does not live here: who notices (noticing), the flights (draw, scenes), what is asked of them
(laws, whole_flight).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from mission.engine import (
    core,
    ending,
    engine,
    limits,
    monitor,
    orders,
    restart,
    run,
    vehicle_state,
)
from mission.engine.ascent import Ascent
from mission.engine.bounds import Bounds, in_force
from mission.engine.clearance import Clearance
from mission.engine.core import Core
from mission.engine.engine import Engine
from mission.engine.limits import LIMITS
from mission.engine.outputs import OutputKeeper
from mission.engine.rest import Rest
from mission.engine.run import Run
from mission.engine.vehicle_state import VehicleState
from mission.model import Action, By, Edge, Health, Outcome, Result, Safety, Tx
from mission.model.vehicle import Vehicle
from mission.navigation.belief import DepthBelief
from mission.navigation.fixes import Receiver
from mission.navigation.health import SensorHealth
from mission.onboard.runtime import frontseat, line, operator_server
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.copies import Copies
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.outer_loop import LoopCloser
from mission.onboard.runtime.resume_marker import ResumeMarker
from mission.verification.campaign.surgery import (
    Break,
    Broken,
    Surgery,
    always,
    as_healthy,
    instead,
    nothing,
    same,
)
from protocol.messages import UPWARD, Fix, Manual, Order, SetSafety
from protocol.vehicles import vehicle_row


@contextmanager
def broken(name: str) -> Iterator[None]:
    """Within it the rule does not hold. KeyError for a name that is not in BROKEN."""
    surgery = Surgery()
    try:
        BROKEN[name].how(surgery)
        yield
    finally:
        surgery.undo()


# --- ways of breaking ----------------------------------------------------------------------------


def _never_acts(name: str) -> Break:
    others = {each: row for each, row in LIMITS.items() if each != name}
    return lambda s: s.put(monitor, "LIMITS", others)


def _without_way(way: Any) -> Break:
    honest = vehicle_row

    def fewer(codec: str) -> Any:
        row = honest(codec)
        return replace(row, ways=tuple(w for w in row.ways if w != way))

    return instead(core, "vehicle_row", fewer)


def _sensor_is_healthy(sensor: str) -> Break:
    honest = SensorHealth.of

    def of(self: SensorHealth, name: str, now: float) -> Health:
        return Health(True, "", 0.0) if name == sensor else honest(self, name, now)

    return instead(SensorHealth, "of", of)


def _restart_only_stops(surgery: Surgery) -> None:
    honest = Core.surface

    def surface(self: Core, name: str, why: str, by: By, *rest: Any) -> None:
        if name == "restart":
            self.stop_quietly(why)
        else:
            honest(self, name, why, by, *rest)

    surgery.put(Core, "surface", surface)


def _marker_not_kept(surgery: Surgery) -> None:
    surgery.put(ResumeMarker, "follow", lambda self, under_way, now: None)
    surgery.put(ResumeMarker, "foresee", lambda self, leaf: "")


def _relays_first(surgery: Surgery) -> None:
    honest = Frontseat.next_out

    def relays_before(self: Frontseat, now: float) -> list[Tx]:
        return [self._transmit(*self._relays.take(), now)] if self._relays else honest(self, now)

    surgery.put(Frontseat, "next_out", relays_before)


def _turns_with_auto_closed(surgery: Surgery) -> None:
    honest = Core.mind_rest

    def mind_rest(self: Core) -> None:
        known, self.auto = self.auto, True
        honest(self)
        self.auto = known

    surgery.put(Core, "mind_rest", mind_rest)


def _starts_anywhere(surgery: Surgery) -> None:
    honest = orders.why_not_fly

    def why_not_fly(*given: Any) -> str:
        why = honest(*given)
        return "" if why.endswith("a mission starts at the surface") else why

    surgery.put(orders, "why_not_fly", why_not_fly)


def _starts_with_auto_closed(surgery: Surgery) -> None:
    honest = orders.why_not_start

    def why_not_start(of: Core) -> str:
        why = honest(of)
        return "" if why == "node AUTO is closed" else why

    surgery.put(orders, "why_not_start", why_not_start)


def _clears_anywhere(surgery: Surgery) -> None:
    surgery.put(orders, "_at_surface", lambda of: True)


def _loosest(surgery: Surgery) -> None:
    def without(vehicle: Vehicle, mission: Safety | None, operator: SetSafety) -> Bounds:
        return in_force(vehicle, mission, SetSafety())

    surgery.put(core, "in_force", without)


def _legs_for_ever(surgery: Surgery) -> None:
    honest = Run.due

    def due(self: Run, edge: Edge, known: VehicleState) -> float | None:
        return None if edge.by in (By.FOR, By.TIMEOUT) else honest(self, edge, known)

    surgery.put(Run, "due", due)


def _refusals_accepted(surgery: Surgery) -> None:
    honest = Core.take_outcome

    def take(self: Core, outcome: Outcome) -> None:
        accepted = outcome.result is Result.REFUSED
        honest(self, replace(outcome, result=Result.ACCEPTED) if accepted else outcome)

    surgery.put(Core, "take_outcome", take)


def _stop_every_five_seconds(surgery: Surgery) -> None:
    honest = Frontseat.poll

    def poll(self: Frontseat, now: float) -> tuple[list[Tx], list[Outcome]]:
        sent, outcomes = honest(self, now)
        due = not sent and now >= self._free and int(now) % 5 == 0
        return ([*sent, Tx(now, "vehicle", b"@ZAX0$", "every 5 s")] if due else sent), outcomes

    surgery.put(Frontseat, "poll", poll)


def _every_place_is_news(surgery: Surgery) -> None:
    honest = Receiver.take

    def take(self: Receiver, fix: Fix) -> None:
        honest(self, fix)
        self.fresh = True

    surgery.put(Receiver, "take", take)


def _no_contradiction(surgery: Surgery) -> None:
    surgery.put(DepthBelief, "_contradict", lambda self, t, why, *, moves: None)


def _fixes_count_against_movement(surgery: Surgery) -> None:
    honest = surgery.found(DepthBelief, "_floats")

    def floats(self: DepthBelief, t: float, moved: float, receiver: Receiver) -> bool:
        return bool(honest(self, t, 0.0, receiver))

    surgery.put(DepthBelief, "_floats", floats)


def _pushes_in_the_dark(surgery: Surgery) -> None:
    honest = surgery.found(Ascent, "_may_lift")

    def may_lift(self: Ascent, way: Any, depth: float | None) -> bool:
        return depth is None or honest(self, way, depth)

    surgery.put(Ascent, "_may_lift", may_lift)


def _forgets_depths(surgery: Surgery) -> None:
    honest = surgery.found(Rest, "take")

    def take(self: Rest, t: float, depth: float | None, *deep: float) -> None:
        if depth is None:
            self.begin()
        honest(self, t, depth, *deep)

    surgery.put(Rest, "take", take)


def _ends_at_once(surgery: Surgery) -> None:
    """With an X0, as every stop does, and nobody stays."""
    surgery.put(ending, "go_on", lambda of: None)
    surgery.put(ending, "begin", lambda of, order: of.stop_quietly("the program is ended"))
    surgery.put(ending, "settled", lambda of: True)
    surgery.put(Engine, "settled", property(lambda self: True))


def _ascent_never_changes(surgery: Surgery) -> None:
    def act(self: Ascent, now: float, *seen: Any) -> tuple[Action, ...]:
        return ()

    surgery.put(Ascent, "act", act)


_REASONS: Mapping[str, str] = {
    "hard depth": "the depth in force acts before it, at rest whatever sinks is brought up",
    "depth contradicted": "a depth that is contradicted is unknown, and acts as such 6 s later",
    "leak": "the AUV reports no leak; every limit has its bounds tried in test_limits",
}


def _goes_as_deep_as_asked(s: Surgery) -> None:
    s.put(Clearance, "_within", lambda _self, held, _bottom: held.depth)


_RULES: Mapping[str, Broken] = {
    "depth margin": Broken("R5: 1 m beyond the depth", instead(limits, "DEPTH_MARGIN", 10.0)),
    "silence": Broken("R8: 5 s without a report", instead(limits, "SILENCE", 60.0)),
    "operator's limits": Broken("R5: the tightest of three", _loosest, alike=same),
    "restart": Broken("R7: a restart surfaces", _restart_only_stops),
    "latch": Broken("R7: what is under way is kept", _marker_not_kept),
    "relays first": Broken("R7: X and W before everything", _relays_first),
    "surface at once": Broken(
        "R7: 6 s of shallow depth", instead(vehicle_state, "SURFACE_TIME", 0.0)
    ),
    "stuck receiver": Broken("R7: a stuck receiver proves nothing", _every_place_is_news),
    "fix under water": Broken(
        "R7: a depth contradicts a fix", instead(vehicle_state, "FIX_DEPTH", 1e9)
    ),
    "belief": Broken("a depth is believed as far as something agrees", _no_contradiction),
    "depth that moves": Broken(
        "R5: a depth that moves is believed again",
        nothing(DepthBelief, "_moves_along", False),
        alike=same,
    ),
    "moving depth": Broken(
        "R7: an ascent goes by the change of a depth",
        instead(VehicleState, "moving_depth", property(lambda self: self.depth)),
        alike=same,
    ),
    "fixes against movement": Broken(
        "R5: fixes contradict no depth that moves", _fixes_count_against_movement, alike=same
    ),
    "fixes too early": Broken(
        "R7: no fix before it can be up", nothing(VehicleState, "_may_be_up", True), alike=same
    ),
    "surface behind a silence": Broken(
        "R7: no silence among the 6 s",
        nothing(VehicleState, "_was_silent", False),
        "takes a rise through the surface as a silence ends; exhaustive has it in every state",
        same,
    ),
    "surface by one report": Broken(
        "R7: two reports of a shallow depth",
        nothing(VehicleState, "_told_again", True),
        "takes a silence that begins at the surface; exhaustive has it in every state",
        same,
    ),
    "unchanged depth": Broken(
        "R7: behind a restart it has to change",
        nothing(VehicleState, "_has_changed", True),
        alike=same,
    ),
    "surface behind a restart": Broken(
        "R7: what proves it counts from 6 s on",
        instead(restart, "UNWATCHED", 0.0),
        "a depth has to change first, and fixes to settle: either holds without it",
    ),
    "sank unseen": Broken("R7, at rest: what sank while no depth was known", _forgets_depths),
    "pushed down again": Broken(
        "R7: upside down, no push that led deeper",
        instead(Ascent, "_may_lift", lambda self, way, depth: depth is not None),
        "D12 brings it up before a second round; with both broken the law of it tells",
        same,
    ),
    "pushed in the dark": Broken(
        "R7: upside down and blind, no push", _pushes_in_the_dark, alike=same
    ),
    "safe outputs": Broken(
        "R18: an emergency makes outputs safe",
        nothing(OutputKeeper, "_make_safe"),
        "the AUV of these flights has no outputs; each state tries them in test_outputs",
    ),
    "unconfirmed loop": Broken(
        "R17: what nobody confirmed holds nothing",
        instead(line, "closer_of", lambda loop: None if loop is None else LoopCloser(loop)),
        "these flights are the AUV's, which holds by itself; test_outer_loop tries it",
    ),
    "copies": Broken("R12: a copy of a command", nothing(Copies, "judge"), alike=same),
    "orderly end": Broken("R7: an orderly end brings it up first", _ends_at_once),
    "sinks at rest": Broken(
        "R7, at rest: what sinks is brought up", always(Rest, "sinks", ""), alike=same
    ),
    "stays down": Broken(
        "R7, at rest: stopped, and it does not rise", nothing(Rest, "stays_down", ""), alike=same
    ),
    "held up": Broken(
        "R7, at rest: what sank out of surfaced", always(Ascent, "pushes_up", False), alike=same
    ),
    "rest with AUTO closed": Broken("R7, at rest: AUTO closed", _turns_with_auto_closed),
    "way W": Broken("R7: W is one of the ways", _without_way(Order.SURFACE)),
    "way U12": Broken("R7: X0 and U12 is one of the ways", _without_way(UPWARD)),
    "way X0": Broken("R7: letting go is one of the ways", _without_way(Order.STOP)),
    "way D12": Broken("R7: upside down D12", nothing(Ascent, "_may_push_down", False), alike=same),
    "ways in turn": Broken("R7: the depth has to fall", _ascent_never_changes),
    "upside down": Broken(
        "R7: upside down is a state", always(VehicleState, "overturned", False), alike=same
    ),
    "cleared below": Broken("R7: cleared at the surface", _clears_anywhere, alike=same),
    "started below": Broken("R7: started at the surface", _starts_anywhere, alike=same),
    "held stick": Broken("R6: every stick still for 2 s", instead(orders, "STICK_QUIET", 0.0)),
    "neutral stick": Broken(
        "R6: no neutral M takes over", always(Manual, "neutral", False), alike=same
    ),
    "any stick": Broken("R6: whoever holds it", nothing(Engine, "hear_stick")),
    "silent stick": Broken("R6: 2 s without M", instead(engine, "STICK_QUIET", 30.0)),
    "forgotten stick": Broken("R6: 60 s without M", nothing(Core, "stick_forgotten")),
    "modem stick": Broken("R6: M but by modem", instead(operator_server, "MODEM", "nobody")),
    "commander": Broken("R12: one commands", nothing(Commander, "why_not", ""), alike=same),
    "AUTO ends": Broken("R13: closing AUTO ends a mission", nothing(Core, "auto_off")),
    "AUTO starts": Broken("R13: no @AA until it is open", _starts_with_auto_closed, alike=same),
    "stop again": Broken("R7: X until it is acknowledged", nothing(Core, "stop_again")),
    "stop doubted": Broken("R7: X where a report shows a thruster", nothing(Core, "doubt_stop")),
    "line doubted": Broken(
        "R8: said again behind a line that was away", nothing(Core, "doubt_line")
    ),
    "refused set": Broken("R8: a set answered N", _refusals_accepted),
    "clock of a leg": Broken("every leg has its clock", _legs_for_ever),
    "blind leg": Broken("R8: a reading that a leg needs", instead(run, "BLIND_TIME", 1e9)),
    "healthy depth": Broken(
        "a depth is not believed", _sensor_is_healthy("depth"), alike=as_healthy
    ),
    "healthy heading": Broken(
        "a heading is not believed", _sensor_is_healthy("heading"), alike=as_healthy
    ),
    "healthy attitude": Broken(
        "an attitude is not believed", _sensor_is_healthy("attitude"), alike=as_healthy
    ),
    "healthy altitude": Broken(
        "an altitude is not believed", _sensor_is_healthy("altitude"), alike=as_healthy
    ),
    "above the bottom": Broken(
        "R5: a depth kept above the bottom", _goes_as_deep_as_asked, alike=same
    ),
    "gap": Broken("20 ms between two frames", instead(frontseat, "GAP_S", 0.0)),
    "unasked": Broken("nothing that nothing asked for", _stop_every_five_seconds),
}

BROKEN: Mapping[str, Broken] = {
    **{
        f"limit {row.name}": Broken(
            f"R5: {row.name}", _never_acts(row.name), _REASONS.get(row.name, "")
        )
        for row in LIMITS.values()
    },
    **_RULES,
}
