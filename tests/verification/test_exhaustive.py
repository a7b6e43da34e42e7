"""The exhaustive proof's own laws: it covers its tables, and each kind of broken engine is seen."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from links.base import Rx
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.engine import core, ending, orders, run, vehicle_state
from mission.engine.ascent import Ascent
from mission.engine.bounds import Bounds
from mission.engine.clearance import Clearance
from mission.engine.engine import Engine
from mission.engine.limits import LIMITS, Limit
from mission.engine.monitor import LimitMonitor
from mission.model import AUTONOMOUS, MANUAL_WAITING, STOPPED, SURFACED, Action, By, Tx, Verdict
from mission.model.shipped import missions_folder
from mission.model.vehicle import Vehicle
from mission.navigation.added import Seen
from mission.navigation.belief import DepthBelief
from mission.navigation.health import SensorHealth, _Monitor
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.copies import Copies
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.node_switching import NodeSwitching
from mission.onboard.runtime.obeyed import Obeyed
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.runtime.situation import Situation
from mission.onboard.runtime.staging import Staging
from mission.onboard.runtime.uploads import Uploads
from mission.verification.exhaustive.cell import Configuration
from mission.verification.exhaustive.commands import COMMANDS
from mission.verification.exhaustive.configurations import WAYS, Ground, configurations, ground
from mission.verification.exhaustive.events import events
from mission.verification.exhaustive.fork import Fork
from mission.verification.exhaustive.laws import _line_was_away
from mission.verification.exhaustive.run import LAWS, Found, examine_ground, unasked
from mission.verification.exhaustive.world import World
from protocol.messages import UPWARD, Order, SetSafety

pytestmark = pytest.mark.proof  # long: make proofs

MISSIONS = missions_folder()
EVERY = 5  # of the configurations: a sample that asks every law
samples = pytest.mark.xdist_group("samples")  # judged once, by the worker of them all


@pytest.fixture(scope="module")
def survey() -> Ground:
    return ground(prepare(MISSIONS / "harbour-survey.yaml"), "as-built")


@pytest.fixture(scope="module")
def sample(survey: Ground) -> Found:
    return examine_ground(survey, EVERY)


@samples
def test_no_cell_of_a_sample_breaks_a_law(sample: Found) -> None:
    assert sample.violations == []
    assert sample.cells == sample.configurations * sample.events
    assert sample.events == len(events()) - 1  # the AUV reports no leak


def test_the_other_profile_and_mission_neither() -> None:
    found = examine_ground(ground(prepare(MISSIONS / "bottom-following.yaml"), "documented"), 17)
    assert found.violations == []


@pytest.fixture(scope="module")
def kept_clear(tmp_path_factory: pytest.TempPathFactory) -> Ground:
    """A depth that is kept above the bottom: 19 m as it is seen, 12 m where nothing is."""
    path = tmp_path_factory.mktemp("missions") / "clear.yaml"
    path.write_text(
        "mission: clear\nhome: {latitude: 30.2874595, longitude: 120.1535765}\n"
        "safety: {radius: 1000 m, time: 30 min, depth: 28 m}\nassume: {floor: 16 m}\nlegs:\n"
        "  - along: {depth: 24 m never below altitude 4 m, heading: 0, gear: 4, timeout: 9 min}\n"
        "  - up: {surface: true, until: fix, timeout: 3 min}\n"
        "on:\n  - {when: battery < 11 V, held: 10 s, do: up}\n",
        encoding="utf-8",
    )
    return ground(prepare(path), "as-built")


@pytest.fixture(scope="module")
def clear(kept_clear: Ground) -> Found:
    return examine_ground(kept_clear, EVERY)


@samples
def test_no_cell_of_a_depth_above_the_bottom_breaks_a_law(clear: Found) -> None:
    assert clear.violations == []


@samples
def test_every_law_is_asked_in_the_samples(sample: Found, clear: Found) -> None:
    assert set(unasked(sample)) <= {"a depth is kept above the bottom"}
    assert "a depth is kept above the bottom" not in unasked(clear)


def test_every_limit_has_its_event() -> None:
    assert {row.name for row in LIMITS.values()} == {e.limit for e in events() if e.limit}


def test_names_of_events_laws_and_ways_are_unique() -> None:
    for names in ([e.name for e in events()], list(LAWS), [w.name for w in WAYS]):
        assert len(set(names)) == len(names)


def test_every_leg_in_its_first_and_last_round_is_there(survey: Ground) -> None:
    legs = {s.path for s in survey.chart.states if s.leg}
    found = [c for c, _ in configurations(survey)]
    assert {c.leaf for c in found if c.region == "autonomous"} == legs
    assert {c.leaf for c in found if c.region == "manual"} == legs | {""}
    rounds = {c.rounds for c in found if c.leaf == "autonomous/rows/out"}
    assert rounds == {(("autonomous/rows", 1),), (("autonomous/rows", 2),)}


@pytest.mark.parametrize("mission", ["lawnmower", "transect", "loiter"])
def test_no_leg_is_at_its_end_where_a_proof_begins(mission: str) -> None:
    for configuration, world in configurations(
        ground(prepare(MISSIONS / f"{mission}.yaml"), "as-built")
    ):
        if configuration.region == "autonomous" and configuration.quiet:
            world.wait(3.0)  # the next report, and an estimate from it
            assert world.state == configuration.leaf, configuration.name


def test_a_copy_of_a_drive_goes_on_as_the_drive_would(survey: Ground) -> None:
    forks = Fork(survey.under_way.copy())
    straight = forks.copy()
    straight.wait(30.0)
    detour = forks.copy()
    detour.say(b"@ZAX0$@AC$@MMF5$")
    detour.wait(10.0)
    again = forks.copy()
    again.wait(30.0)
    assert again.sent == straight.sent
    assert again.notes.steps == straight.notes.steps
    assert again.sea == straight.sea


# --- broken on purpose ----------------------------------------------------------------------------

OUTSTANDING = "autonomous/dive , Z outstanding"
Break = Callable[[pytest.MonkeyPatch], None]


def _refuse_x(patch: pytest.MonkeyPatch) -> None:
    def deaf(c: core.Core, command: object) -> Verdict:
        if isinstance(command, orders.Emergency) and c.active == "emergency/surfacing":
            return Verdict(False, "no")
        return orders.obey(c, command)

    patch.setattr("mission.engine.engine.obey", deaf)


def _clear_while_surfacing(patch: pytest.MonkeyPatch) -> None:
    def clear(c: core.Core, command: object) -> Verdict:
        if not isinstance(command, orders.ClearMission):
            return orders.obey(c, command)
        c.machine.restore(STOPPED)
        c.clear()
        return Verdict(True)

    patch.setattr("mission.engine.engine.obey", clear)


def _no_reason(patch: pytest.MonkeyPatch) -> None:
    command = Frontseat.command
    patch.setattr(Frontseat, "command", lambda self, a: command(self, replace(a, reason="because")))


def _stick_in_emergency(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(orders, "_not_pushed", lambda core: "")


def _never_blind(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(run, "BLIND_TIME", 1e9)


def _limits_sleep(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LimitMonitor, "look", lambda self, reported, fixed: [])


def _areas_are_open(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.engine.limits.breached", lambda *_: "")


def _believe_all(patch: pytest.MonkeyPatch) -> None:
    observe = _Monitor.observe

    def believed(self, row, t, value, moving, doubt):
        observe(self, row, t, value, moving, doubt)
        self.reason, self.good_t, self.good = "", t, value
        return True

    patch.setattr(_Monitor, "observe", believed)
    patch.setattr(DepthBelief, "_contradict", lambda *_, **__: None)


def _a_gap_is_no_doubt(patch: pytest.MonkeyPatch) -> None:
    telemetry = SensorHealth.telemetry
    patch.setattr(
        SensorHealth,
        "telemetry",
        lambda self, t, push: telemetry(self, t._replace(faults=()), push),
    )


def _no_timeout(patch: pytest.MonkeyPatch) -> None:
    due = run.Run.due

    def never(self: run.Run, edge: run.Edge, seen: vehicle_state.VehicleState) -> float | None:
        return None if edge.by in (run.By.TIMEOUT, run.By.FOR) else due(self, edge, seen)

    patch.setattr(run.Run, "due", never)


def _half_a_set(patch: pytest.MonkeyPatch) -> None:
    command = Frontseat.command

    def first_only(self: Frontseat, action: Action) -> object:
        outcome = command(self, action)
        while len(self._queue) > 1:
            self._queue.pop()
        return outcome

    patch.setattr(Frontseat, "command", first_only)


def _lines_always(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Uploads, "is_idle", property(lambda self: True))


def _board_never_needed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(NodeSwitching, "_needs_board", lambda self: "")


def _others_command(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Commander, "why_not", lambda *_: "")


def _forgets_rounds(patch: pytest.MonkeyPatch) -> None:
    resume = core.Core.resume

    def anew(self: core.Core, under_way: run.Run) -> None:
        under_way.rounds.clear()
        resume(self, under_way)

    patch.setattr(core.Core, "resume", anew)


def _stop_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(core.Core, "stop_again", lambda self: None)


def _w_is_enough(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.engine.ascent.TURN", 1e9)


def _no_latch(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.engine.engine.Engine.under_way", property(lambda self: ""))


def _staging_forgets(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Staging, "incomplete", lambda *_: False)


def _refusal_ignored(patch: pytest.MonkeyPatch) -> None:
    def deaf(self: core.Core, outcome: core.Outcome) -> None:
        if outcome.command is Order.STOP and outcome.result is core.Result.ACCEPTED:
            self.stop_at = None

    patch.setattr(core.Core, "take_outcome", deaf)


def _x_comes_last(patch: pytest.MonkeyPatch) -> None:
    command = Frontseat.command

    def keeps(self: Frontseat, action: Action) -> object:
        waiting = list(self._queue)
        outcome = command(self, action)
        if isinstance(action.command, Order):
            self._queue.extend(waiting)
        return outcome

    patch.setattr(Frontseat, "command", keeps)


def _relays_first(patch: pytest.MonkeyPatch) -> None:
    following = Frontseat.next_out

    def polite(self: Frontseat, now: float) -> list[Tx]:
        if self._relays and not self._urgent:
            return [self._transmit(*self._relays.take(), now)]
        return following(self, now)

    patch.setattr(Frontseat, "next_out", polite)


def _copies_are_meant(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Copies, "judge", lambda *_: None)


def _orders_in_contents_alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Obeyed, "found", lambda self, data: [])


def _surface_by_faith(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(
        vehicle_state.VehicleState, "surfaced", lambda self, since: self.now > since + 1.0
    )


def _gives_up(patch: pytest.MonkeyPatch) -> None:
    act = Ascent.act

    def tired(self: Ascent, now: float, *seen: Any) -> tuple[Action, ...]:
        return act(self, now, *seen) if now < self.began + 25.0 else ()

    patch.setattr(Ascent, "act", tired)


def _thrust_at_the_surface(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(core.Core, "_stop", lambda self, why: (Action(UPWARD, why),))


def _clock_anew(patch: pytest.MonkeyPatch) -> None:
    resume = core.Core.resume

    def anew(self: core.Core, under_way: run.Run) -> None:
        under_way.started = self.now
        resume(self, under_way)

    patch.setattr(core.Core, "resume", anew)


def _age_goes_on(patch: pytest.MonkeyPatch) -> None:
    begin = LimitMonitor.begin

    def older(self: LimitMonitor, now: float) -> None:
        heard = self.heard
        begin(self, now)
        self.heard = heard

    patch.setattr(LimitMonitor, "begin", older)


def _blind_in_manual(patch: pytest.MonkeyPatch) -> None:
    look = LimitMonitor.look

    def only_with_a_set(self: LimitMonitor, reported: bool, fixed: bool) -> list[Limit]:
        return look(self, reported, fixed) if self.sent is not None else []

    patch.setattr(LimitMonitor, "look", only_with_a_set)


def _a_round_too_many(patch: pytest.MonkeyPatch) -> None:
    repeat = run.repeat_of
    patch.setattr(run, "repeat_of", lambda chart, path: repeat(chart, path) + 1)


def _refused_is_timeout(patch: pytest.MonkeyPatch) -> None:
    due = run.Run.due

    def late(self: run.Run, edge: run.Edge, seen: vehicle_state.VehicleState) -> float | None:
        if self.refused and edge.by is run.By.ELSE:
            return None
        return seen.now if self.refused and edge.by is run.By.FOR else due(self, edge, seen)

    patch.setattr(run.Run, "due", late)


def _no_gap(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.onboard.runtime.frontseat.GAP_S", 0.0)


def _impatient(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.onboard.runtime.frontseat.ANSWER_S", 0.1)


def _four_tries(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("mission.onboard.runtime.frontseat.TRIES", 4)


def _loosest(patch: pytest.MonkeyPatch) -> None:
    in_force = core.in_force

    def operators(vehicle: Vehicle, mission: object, operator: SetSafety) -> Bounds:
        own = in_force(vehicle, None, SetSafety())
        told = {n: v for n in ("radius", "time", "depth") if (v := getattr(operator, n))}
        return replace(own, **told)

    patch.setattr(core, "in_force", operators)


def _at_the_first_sample(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(LimitMonitor, "_lasts", lambda self, row: True)


def _unknown_is_shallow(patch: pytest.MonkeyPatch) -> None:
    forgotten = core.Core.stick_forgotten

    def bold(self: core.Core) -> None:
        with pytest.MonkeyPatch.context() as inner:
            if self.vehicle_state.depth is None:
                inner.setattr(core, "SURFACE_DEPTH", 1e9)
                inner.setattr(vehicle_state.VehicleState, "depth", 0.0)
                inner.setattr(vehicle_state.VehicleState, "lives", True)
            forgotten(self)

    patch.setattr(core.Core, "stick_forgotten", bold)


def _guesses_an_order(patch: pytest.MonkeyPatch) -> None:
    receive = Runtime.receive

    def lenient(self: Runtime, rx: Rx) -> object:
        return receive(self, rx._replace(data=rx.data.replace(b"@ZAX1$", b"@ZAX0$")))

    patch.setattr(Runtime, "receive", lenient)


def _ends_with_a_stop(patch: pytest.MonkeyPatch) -> None:
    stop = lambda c: None if c.region == "emergency" else c.stop_in("end", SURFACED, "over")  # noqa: E731
    patch.setattr(ending, "go_on", stop)


def _ends_as_it_is(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(ending, "settled", lambda c: True)


def _turns_with_auto_closed(patch: pytest.MonkeyPatch) -> None:
    mind_rest = core.Core.mind_rest

    def anyway(self: core.Core) -> None:
        auto, self.auto = self.auto, True
        mind_rest(self)
        self.auto = auto

    patch.setattr(core.Core, "mind_rest", anyway)


def _ends_with_w_everywhere(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(ending, "go_on", lambda c: c.surface("W", "over", By.OPERATOR))


def _leaves_the_stick_as_it_is(patch: pytest.MonkeyPatch) -> None:
    settled = ending.settled
    patch.setattr(ending, "settled", lambda c: c.active == MANUAL_WAITING or settled(c))


def _restart_only_stops(patch: pytest.MonkeyPatch) -> None:
    quietly = lambda c, before: c.stop_quietly("a restart")  # noqa: E731
    patch.setattr("mission.engine.engine.begin_again", quietly)
    patch.setattr("mission.verification.exhaustive.world._BEGUN", {})


def _ascent_after_the_last_words(patch: pytest.MonkeyPatch) -> None:
    say = core.Core.say_last

    def goes_on(self: core.Core, action: Action) -> None:
        kept = self.ascent
        say(self, action)
        self.ascent = kept

    patch.setattr(core.Core, "say_last", goes_on)


def _silence_is_nothing(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(vehicle_state.VehicleState, "_was_silent", lambda self, report: False)


def _one_report_is_enough(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(vehicle_state.VehicleState, "_told_again", lambda self: True)


def _what_stands_is_proof(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(vehicle_state.VehicleState, "lives", property(lambda self: True))
    patch.setattr("mission.verification.exhaustive.world._BEGUN", {})


def _up_at_once(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(vehicle_state.VehicleState, "_may_be_up", lambda self, now: True)
    patch.setattr("mission.verification.exhaustive.world._BEGUN", {})


def _goes_by_belief_alone(patch: pytest.MonkeyPatch) -> None:
    believed = property(lambda self: self.depth)
    patch.setattr(vehicle_state.VehicleState, "moving_depth", believed)


def _pushes_down_again(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Ascent, "_may_lift", lambda self, way, depth: depth is not None)


def _any_place_opens_the_gate(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Seen, "confirmed", lambda self, a: True)
    patch.setattr(Seen, "insists", lambda self, a: True)


def _pushes_in_the_dark(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Ascent, "_may_lift", lambda self, way, depth: True)


def _tells_below(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Situation, "_afloat", lambda self, now: True)


def _a_line_is_back_unheard(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(core.Core, "doubt_line", lambda self: None)


def _limits_everywhere(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Engine, "_acts", lambda self, row: True)


BROKEN: tuple[tuple[Break, str, str], ...] = (
    (_refuse_x, "surfacing", "X acts from everywhere within the step"),
    (_refuse_x, "surfacing", "W acts from everywhere within the step"),
    (_clear_while_surfacing, "surfacing", "@AC by state"),
    (_clear_while_surfacing, "surfacing", "no exit from an emergency but R7's"),
    (_no_reason, "surfacing", "no command without a reason"),
    (_stick_in_emergency, "stopped, stick held", "M takes over at once, an emergency by a push behind 2 s of silence"),
    (_any_place_opens_the_gate, "autonomous/dive , quiet", "from region to region only for a cause"),
    (_never_blind, "autonomous/dive , quiet", "a set whose reading is unknown is given up"),
    (_limits_sleep, "autonomous/dive , quiet", "a breach leads to its response where it acts, and only there"),
    (_areas_are_open, "autonomous/dive , quiet", "a breach leads to its response where it acts, and only there"),
    (_limits_sleep, "autonomous/dive , quiet", "who is left alone comes up"),
    (_limits_sleep, "autonomous/dive , quiet", "not sure of the radius: the mission's own way"),
    (_limits_sleep, "autonomous/dive , quiet", "after a brown-out the set leaves once more"),
    (_believe_all, "autonomous/dive , quiet", "unknown never opens an exit"),
    (_a_gap_is_no_doubt, "autonomous/dive , quiet", "a set whose reading is unknown is given up"),
    (_no_timeout, "autonomous/rows/turn round 1 of autonomous/rows, quiet", "every leg is left when its time is up"),
    (_half_a_set, "autonomous/rows/turn round 1 of autonomous/rows, quiet", "a leg's whole set leaves on entry"),
    (_lines_always, "autonomous/dive , quiet", "@AW only in idle"),
    (_lines_always, "autonomous/dive , quiet", "@ST only in idle, not by modem"),
    (_lines_always, "autonomous/dive , quiet", "@AQ tells the store's state"),
    (_board_never_needed, "autonomous/dive , quiet", "@NS by state"),
    (_others_command, "ready", "who does not command only reads"),
    (_forgets_rounds, "manual/waiting, interrupted autonomous/rows/out round 2 of autonomous/rows", "rounds go on after an interruption"),
    (_stop_once, "autonomous/dive , quiet", "X0 every 500 ms until it is acknowledged"),
    (_w_is_enough, "ready", "from everywhere to the surface by W"),
    (_no_latch, "autonomous/dive , quiet", "what is under way is kept for a restart"),
    (_staging_forgets, "ready", "@AA by state"),
    (_refusal_ignored, "autonomous/dive , Z outstanding", "a refused Z leads to the leg's else"),
    (_x_comes_last, OUTSTANDING, "in stopped nothing leaves but X0 and relays"),
    (_x_comes_last, OUTSTANDING, "in surfacing nothing leaves but W, X0, U12, D12 and relays"),
    (_relays_first, "surfacing", "both halves of an ascent leave under a slider"),
    (_copies_are_meant, "ready", "a late copy does nothing that is not in force"),
    (_orders_in_contents_alone, "ready", "W acts from everywhere within the step"),
    (_thrust_at_the_surface, "surfacing", "in surfaced nothing leaves but X0 and relays"),
    (_surface_by_faith, "surfacing", "at the surface is who is there"),
    (_gives_up, "surfacing", "an ascent tries every way and never gives up"),
    (_clock_anew, "autonomous/dive , quiet", "an interruption does not stop the mission's clock"),
    (_age_goes_on, "autonomous/dive , quiet", "the age of the reports starts again with @AA"),
    (_blind_in_manual, "waiting", "in manual a limit is reported"),
    (_a_round_too_many, "autonomous/rows/back round 2 of autonomous/rows, quiet", "a mission goes along its chart, round by round"),
    (_refused_is_timeout, "autonomous/rows/turn round 1 of autonomous/rows, Z outstanding", "a refused Z leads to the leg's else"),
    (_no_gap, OUTSTANDING, "20 ms between two frames to the STM32"),
    (_impatient, OUTSTANDING, "one Z outstanding"),
    (_four_tries, OUTSTANDING, "a frame is tried three times"),
    (_loosest, "autonomous/dive , quiet", "a breach leads to its response where it acts, and only there"),
    (_at_the_first_sample, "autonomous/dive , quiet", "from region to region only for a cause"),
    (_unknown_is_shallow, "waiting", "60 s after the stick: idle at the surface, surfacing where deep"),
    (_ends_with_a_stop, "autonomous/dive , quiet", "an ordered end brings up what is under way first"),
    (_ends_as_it_is, "autonomous/dive , quiet", "an ordered end brings up what is under way first"),
    (_turns_with_auto_closed, "surfaced, AUTO closed", "nothing turns by itself while AUTO is closed"),
    (_ends_with_w_everywhere, "ready", "an ordered end turns nothing where nothing is under way"),
    (_leaves_the_stick_as_it_is, "waiting, AUTO closed", "an ordered end turns nothing where nothing is under way"),
    (_restart_only_stops, "autonomous/dive , quiet", "a restart surfaces what was under way and leaves the rest at rest"),
    (_ascent_after_the_last_words, "surfacing", "the last words of a program are X0 and U12"),
    (_guesses_an_order, "ready", "no other Z of an operator's does anything"),
    (_refusal_ignored, "autonomous/dive , two Z lost, one outstanding", "three Z without an answer surface"),
    (_silence_is_nothing, "surfacing", "what was shallow before a silence proves no surface"),
    (_one_report_is_enough, "surfacing", "what was shallow before a silence proves no surface"),
    (_what_stands_is_proof, "autonomous/dive , quiet", "a restart surfaces what was under way and leaves the rest at rest"),
    (_up_at_once, "surfacing", "without a depth no fix proves the surface too soon"),
    (_up_at_once, "autonomous/dive , quiet", "a restart surfaces what was under way and leaves the rest at rest"),
    (_goes_by_belief_alone, "surfacing", "what makes a depth fall of which the zero is doubted is kept"),
    (_pushes_down_again, "surfacing", "upside down no push that led deeper is tried again"),
    (_tells_below, "autonomous/dive , quiet", "no @VS unasked below it"),
    (_a_line_is_back_unheard, "surfacing", "behind a line that was away what holds is said again"),
    (_limits_everywhere, "waiting", "a breach leads to its response where it acts, and only there"),
    (_pushes_in_the_dark, "surfacing", "upside down and blind it is let go"),
)  # fmt: skip


@pytest.fixture(scope="module")
def worlds(survey: Ground) -> dict[str, tuple[Configuration, Fork[World]]]:
    wanted = {name for _, name, _ in BROKEN}
    return {c.name: (c, Fork(w)) for c, w in configurations(survey) if c.name in wanted}


@pytest.mark.parametrize(
    ("left", "wrong"), [([], False), ([b"@ZAX0$"], False), ([b"@ZAU12$"], True)]
)
def test_one_other_command_after_the_line_is_back_is_seen_in_idle(
    left: list[bytes], wrong: bool
) -> None:
    cell = SimpleNamespace(
        event=SimpleNamespace(causes={"line"}),
        configuration=SimpleNamespace(region="idle"),
        region="idle",
        state="idle/ready",
        frames=lambda start: [SimpleNamespace(data=data) for data in left],
    )
    assert bool(_line_was_away(cell)) is wrong  # type: ignore[arg-type]


@pytest.fixture
def patch() -> Iterator[pytest.MonkeyPatch]:
    with pytest.MonkeyPatch.context() as context:
        yield context


@pytest.mark.parametrize(
    ("broken", "name", "law"), BROKEN, ids=lambda v: getattr(v, "__name__", str(v))
)
def test_a_broken_engine_is_seen(broken: Break, name: str, law: str, survey, worlds, patch) -> None:
    from mission.verification.exhaustive.run import _examine

    configuration, fork = worlds[name]
    broken(patch)
    found = Found()
    _examine(configuration, fork.copy(), survey, found)
    assert found.broken[law], dict(found.broken)


def test_a_depth_that_is_not_kept_above_the_bottom_is_seen(kept_clear: Ground, patch) -> None:
    from mission.verification.exhaustive.run import _examine

    name = "autonomous/along , quiet"
    configuration, world = next((c, w) for c, w in configurations(kept_clear) if c.name == name)
    patch.setattr(Clearance, "_within", lambda self, held, bottom: held.depth)
    found = Found()
    _examine(configuration, world, kept_clear, found)
    assert found.broken["a depth is kept above the bottom"], dict(found.broken)


def test_a_set_of_the_same_instant_that_left_before_the_order_is_not_of_its_state() -> None:
    """Told to end in the instant of a report after which a leg steers."""
    from mission.verification.exhaustive.run import _judged, _played

    on = ground(prepare(MISSIONS / "bottom-following.yaml"), "as-built")
    name = "autonomous/home_run , handlers acted, quiet"
    configuration, world = next((c, w) for c, w in configurations(on) if c.name == name)
    fork = Fork(world)
    together = 0
    for event in events():
        if "end" in event.causes:
            cell, fault = _played(configuration, event, on, fork)
            assert list(_judged(cell, fault, Found())) == []
            left, told = cell.frames(until=cell.world.ended_after), cell.steps[-1]
            together += left[-1].t == told.t
    assert together


def test_what_leaves_the_drive_as_an_exception_is_a_violation(survey, worlds, patch) -> None:
    from mission.verification.exhaustive.run import _examine

    def fails(self: core.Core) -> None:
        raise RuntimeError("broken on purpose")

    configuration, fork = worlds["ready"]
    patch.setattr(core.Core, "take_stick", fails)
    found = Found()
    _examine(configuration, fork.copy(), survey, found)
    assert "broken on purpose" in found.violations[0]["seen"]


def test_a_law_that_is_asked_nowhere_is_an_error_of_the_command(patch) -> None:
    patch.setattr("mission.verification.exhaustive.run.events_of", lambda line: COMMANDS[:1])
    done = CliRunner().invoke(
        main, ["exhaustive", str(MISSIONS / "yoyo-profile.yaml"), "--workers", "1"]
    )
    assert done.exit_code == 1
    assert "no cell asks" in done.stderr
    report = json.loads(done.stdout.splitlines()[-1])
    assert report["violations"] == []
    assert report["events"] == 1
    assert report["cells"] == report["configurations"] > 100
    assert report["missions"] == 1


def test_a_law_about_a_kind_of_leg_that_a_mission_of_ones_own_has_not_is_a_note(tmp_path) -> None:
    """The bytes of motor boards alone are not spoken, and that is said, too."""
    for vehicle, code in (("auv", 0), ("mainboard", 2)):
        path = tmp_path / f"{vehicle}.yaml"
        path.write_text(
            f"mission: pool\nvehicle: {vehicle}\nstart: without fix\n"
            "safety: {radius: 200 m, time: 5 min, depth: 5 m}\n"
            "legs:\n  - a: {gear: 4, for: 5 s}\n"
        )
        with pytest.MonkeyPatch.context() as patch:
            every = frozenset().union(*(law.needs for law in LAWS.values()))
            few = Found({"pool.yaml"}, has=every, asked=Counter(dict.fromkeys(LAWS, 1)))
            del few.asked["rounds go on after an interruption"]
            if code == 0:
                patch.setattr(
                    "mission.verification.exhaustive.run.examine_ground", lambda on, few=few: few
                )
            done = CliRunner().invoke(main, ["exhaustive", str(path), "--workers", "1"])
        assert done.exit_code == code, done.stderr
        told = (
            "note: no leg here is of the kind of: rounds go on" if code == 0 else "speaks the bytes"
        )
        assert told in done.stderr


def test_a_mission_that_cannot_be_read_is_said_so(tmp_path) -> None:
    (tmp_path / "x.yaml").write_text("mission: 3\n")
    done = CliRunner().invoke(main, ["exhaustive", str(tmp_path / "x.yaml"), "--workers", "1"])
    assert done.exit_code == 2
    assert AUTONOMOUS not in done.stdout
