"""A test of the campaign: each safety rule is broken alone, to see whether flights notice.

A row of BROKEN breaks one rule in the running objects of this process, never in a file. The code
that a row names must exist: a rewritten rule needs a rewritten row.

What does not live here: who notices (noticing), the flights (draw, scenes), the laws that flights
must keep (laws, whole_flight).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from mission.engine import (
    engine,
    flying,
    limits,
    orders,
    restart,
    run,
    vehicle_state,
)
from mission.engine.ascent import Ascent
from mission.engine.clearance import Clearance
from mission.engine.core import Core
from mission.engine.engine import Engine
from mission.engine.limits import LIMITS
from mission.engine.outputs import OutputKeeper
from mission.engine.rest import Rest
from mission.engine.vehicle_state import VehicleState
from mission.engine.watch import Descent
from mission.model import Result
from mission.navigation.belief import DepthBelief
from mission.onboard.runtime import frontseat, line, operator_server, repeater
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.copies import Copies
from mission.onboard.runtime.outer_loop import LoopCloser
from mission.verification.campaign import breaks
from mission.verification.campaign.surgery import (
    Broken,
    Surgery,
    always,
    as_healthy,
    instead,
    nothing,
    same,
)
from protocol.messages import UPWARD, Manual, Order


@contextmanager
def broken(name: str) -> Iterator[None]:
    """Break the rule within the context. Raises KeyError for a name that is not in BROKEN."""
    surgery = Surgery()
    try:
        BROKEN[name].how(surgery)
        yield
    finally:
        surgery.undo()


_REASONS: Mapping[str, str] = {
    "hard depth": "the depth in force acts before it, at rest whatever sinks is brought up",
    "depth contradicted": "a depth that is contradicted is unknown, and acts as such 6 s later",
    "leak": "the AUV reports no leak; every limit has its bounds tried in test_contracts",
}


_RULES: Mapping[str, Broken] = {
    "depth margin": Broken("R5: 1 m beyond the depth", instead(limits, "DEPTH_MARGIN", 10.0)),
    "silence": Broken("R8: 5 s without a report", instead(limits, "SILENCE", 60.0)),
    "slow descent": Broken("R5: a descent however slow", nothing(Descent, "_lasts", False)),
    "operator's limits": Broken("R5: the tightest of three", breaks.loosest, alike=same),
    "restart": Broken(
        "R7: a restart surfaces",
        breaks.restart_only_stops,
        when=lambda _core, name, *_, **__: name == "restart",
    ),
    "latch": Broken("R7: what is under way is kept", breaks.marker_not_kept),
    "relays first": Broken(
        "R7: X and W before everything",
        breaks.relays_first,
        when=breaks.has_relays,
    ),
    "relays between": Broken(
        "R7: what is passed on waits for an answer",
        breaks.relays_between_tries,
        when=breaks.has_relays,
    ),
    "lift again": Broken(
        "R7: an ascent's U12 is said again", instead(frontseat, "AGAIN_S", 1e9), alike=same
    ),
    "surface at once": Broken(
        "R7: 6 s of shallow depth", instead(vehicle_state, "SURFACE_TIME", 0.0)
    ),
    "stuck receiver": Broken("R7: a stuck receiver proves nothing", breaks.every_place_is_news),
    "fixes below": Broken(
        "R5: no fix explains a depth that stands under a push", breaks.fixes_explain_what_stands
    ),
    "fix under water": Broken(
        "R7: a depth contradicts a fix", instead(vehicle_state, "FIX_DEPTH", 1e9)
    ),
    "belief": Broken("a depth is believed as far as something agrees", breaks.no_contradiction),
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
        "R5: fixes contradict no depth that moves", breaks.fixes_count_against_movement, alike=same
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
        "R7: two reports of a shallow depth that differ",
        nothing(VehicleState, "_told_again", True),
        "takes a silence that begins at the surface; exhaustive has it in every state",
        same,
    ),
    "unchanged depth": Broken(
        "R7: behind a restart, and in an ascent, it has to change",
        always(VehicleState, "lives", True),
        "a shallow depth that repeats itself proves none either: each holds without the other",
        same,
    ),
    "surface behind a restart": Broken(
        "R7: what proves it counts from 6 s on",
        instead(restart, "UNWATCHED", 0.0),
        "a depth has to change first, and fixes to settle: either holds without it",
    ),
    "sank unseen": Broken(
        "R7, at rest: what sank while no depth was known",
        breaks.forgets_depths,
        when=lambda _rest, _t, depth, *_: depth is None,
    ),
    "pushed down again": Broken(
        "R7: upside down, no push that led deeper",
        instead(Ascent, "_may_lift", lambda self, way, depth: depth is not None),
        "D12 brings it up before a second round; with both broken the law of it tells",
        same,
    ),
    "pushed in the dark": Broken(
        "R7: upside down and blind, no push", breaks.pushes_in_the_dark, alike=same
    ),
    "blind thrust": Broken(
        "R7: full thrust lasts longer where no depth tells",
        nothing(Ascent, "_pushes_on", False),
        alike=same,
    ),
    "goes under": Broken(
        "R7, at rest: no depth, and the fixes end",
        nothing(Core, "mind_fixes"),
        "what sinks at rest without a depth is excused; test_engine_ascent tries it",
        same,
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
    "orderly end": Broken("R7: an orderly end brings it up first", breaks.ends_at_once),
    "sinks at rest": Broken(
        "R7, at rest: what sinks is brought up", always(Rest, "sinks", ""), alike=same
    ),
    "stays down": Broken(
        "R7, at rest: stopped, and it does not rise", nothing(Rest, "stays_down", ""), alike=same
    ),
    "held up": Broken(
        "R7, at rest: what sank out of surfaced", always(Ascent, "pushes_up", False), alike=same
    ),
    "rest with AUTO closed": Broken(
        "R7, at rest: AUTO closed",
        breaks.turns_with_auto_closed,
        when=lambda core: not core.auto,
    ),
    "way W": Broken("R7: W is one of the ways", breaks.without_way(Order.SURFACE)),
    "way U12": Broken("R7: X0 and U12 is one of the ways", breaks.without_way(UPWARD)),
    "way X0": Broken("R7: letting go is one of the ways", breaks.without_way(Order.STOP)),
    "way D12": Broken("R7: upside down D12", nothing(Ascent, "_may_push_down", False), alike=same),
    "ways in turn": Broken("R7: the depth has to fall", breaks.ascent_never_changes),
    "upside down": Broken(
        "R7: upside down is a state", always(VehicleState, "overturned", False), alike=same
    ),
    "cleared below": Broken("R7: cleared at the surface", breaks.clears_anywhere, alike=same),
    "started below": Broken("R7: started at the surface", breaks.starts_anywhere, alike=same),
    "held stick": Broken("R6: every stick still for 2 s", nothing(orders, "_not_pushed", "")),
    "waited words": Broken("R6: what has waited is no push", instead(orders, "WAITED", 1000)),
    "neutral stick": Broken(
        "R6: no neutral M takes over", always(Manual, "neutral", False), alike=same
    ),
    "any stick": Broken("R6: whoever holds it", nothing(Engine, "hear_stick")),
    "silent stick": Broken("R6: 2 s without M", instead(engine, "STICK_QUIET", 30.0)),
    "forgotten stick": Broken("R6: 60 s without M", nothing(Core, "stick_forgotten")),
    "modem stick": Broken("R6: M but by modem", instead(operator_server, "MODEM", "nobody")),
    "commander": Broken("R12: one commands", nothing(Commander, "why_not", ""), alike=same),
    "AUTO ends": Broken("R13: closing AUTO ends a mission", nothing(Core, "auto_off")),
    "AUTO starts": Broken(
        "R13: no @AA until it is open", breaks.starts_with_auto_closed, alike=same
    ),
    "stop again": Broken(
        "R7: X until it is acknowledged",
        nothing(Core, "stop_again"),
        when=lambda core: core.stop_at is not None and core.now >= core.stop_at,
    ),
    "stop doubted": Broken("R7: X where a report shows a thruster", nothing(Core, "doubt_stop")),
    "line doubted": Broken(
        "R8: said again behind a line that was away", nothing(Core, "doubt_line")
    ),
    "refused set": Broken(
        "R8: a set answered N",
        breaks.refusals_accepted,
        when=lambda _core, outcome: outcome.result is Result.REFUSED,
    ),
    "clock of a leg": Broken("every leg has its clock", breaks.legs_for_ever),
    "blind leg": Broken("R8: a reading that a leg needs", instead(run, "BLIND_TIME", 1e9)),
    "healthy depth": Broken(
        "a depth is not believed", breaks.sensor_is_healthy("depth"), alike=as_healthy
    ),
    "healthy heading": Broken(
        "a heading is not believed", breaks.sensor_is_healthy("heading"), alike=as_healthy
    ),
    "healthy attitude": Broken(
        "an attitude is not believed", breaks.sensor_is_healthy("attitude"), alike=as_healthy
    ),
    "healthy altitude": Broken(
        "an altitude is not believed", breaks.sensor_is_healthy("altitude"), alike=as_healthy
    ),
    "above the bottom": Broken(
        "R5: a depth kept above the bottom",
        instead(Clearance, "_within", lambda _self, held, _bottom: held.depth),
        alike=same,
    ),
    "areas": Broken(
        "R5: the mission's areas", instead(flying, "fences", lambda *_: ()), alike=same
    ),
    "pace of a board": Broken(
        "R16, R17: what holds is said again",
        breaks.half_the_pace,
        "the AUV is told a word once; boards of documents 002 to 004 are told again",
    ),
    "stick of a board": Broken(
        "R14: 600 ms without an M",
        instead(repeater, "STICK_S", 60.0),
        "the AUV's STM32 does that by itself; boards of documents 002 to 004 do not",
    ),
    "gap": Broken("20 ms between two frames", instead(frontseat, "GAP_S", 0.0)),
    "unasked": Broken("nothing that nothing asked for", breaks.stop_every_five_seconds),
}

BROKEN: Mapping[str, Broken] = {
    **{
        f"limit {row.name}": Broken(
            f"R5: {row.name}", breaks.never_acts(row.name), _REASONS.get(row.name, "")
        )
        for row in LIMITS.values()
    },
    **_RULES,
}
