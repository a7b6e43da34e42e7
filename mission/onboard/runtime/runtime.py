"""The runtime: the core of the program at sea and in simulation, without clock or IO.

    Rx vehicle --vehicle codec--> Telemetry, Ack --+                +--> Action --> Frontseat --> Tx
    Rx gps, gps2, sensors ------> Fix, Aid --------+--> Engine.step +--> Step, Estimate --> record
    Rx topside, modem --Topside-> commands --------+                +--> Verdict --> Topside --> Tx
    Rx nodes ---Topside

Two event loops drive it: the lock-step loop of the simulation (flight) and asyncio (serve). A loop
passes in every byte, connection and timer with its time, and sends what is returned. All inputs and
outputs are recorded first (records); nothing else affects the runtime. Data that must be durable is
so before the Tx that reports it is returned, but for resume markers: a timer writes those of legs,
emergencies, stick and stops after what is due on the line, so that no disk delays a STOP.

What does not live here: rules of the states (engine), of the line (frontseat), of the operator
(operator_server), files and sockets (store, links).
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from links.base import Rx
from mission import __version__
from mission.engine.engine import Engine, Input
from mission.model import (
    AutoNode,
    Chart,
    Ending,
    LineOpened,
    Loaded,
    Outcome,
    Record,
    Restarted,
    Tx,
    Verdict,
)
from mission.model.alarms import Condition
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime import records as rec
from mission.onboard.runtime.command_target import MissionRefused, Peer
from mission.onboard.runtime.commander import Commander
from mission.onboard.runtime.device_switches import LINK as NODES
from mission.onboard.runtime.device_switches import DeviceSwitches, with_process
from mission.onboard.runtime.line import line_to
from mission.onboard.runtime.mission_validator import MissionValidator
from mission.onboard.runtime.operator_channels import operator_channels
from mission.onboard.runtime.operator_server import OperatorServer
from mission.onboard.runtime.receivers import RECEIVERS, Receivers
from mission.onboard.runtime.relays import channels_of
from mission.onboard.runtime.resume_marker import ResumeMarker
from mission.onboard.runtime.situation import Situation
from mission.onboard.runtime.standing import StandingChanges
from mission.onboard.runtime.wallclock import WallClock
from mission.onboard.store import Store, StoreError, WatchedStore
from protocol.added import AddedDecoder
from protocol.codec import Received
from protocol.messages import (
    Aid,
    ClearMission,
    Command,
    Fix,
    FrameFault,
    StartMission,
    StateReport,
    Status,
    Telemetry,
)
from protocol.tolerances import Tolerances
from protocol.vehicles import codec as vehicle_codec

if TYPE_CHECKING:
    from mission.navigation import Navigation

VEHICLE, SENSORS = "vehicle", "sensors"
MOST_ROUNDS = 10  # at one time: outcomes lead to commands, and these to outcomes
CLOCK = "clock"  # a Tx to it asks the event loop to set the system's clock (R10)


class Runtime:
    """``wall`` is the wall clock at the engine's time 0, in s since 1970 UTC."""

    def __init__(
        self,
        configuration: Configuration,
        vehicle: Vehicle,
        store: Store,
        recorder: rec.Recorder | None = None,
        navigation: Navigation | None = None,
        wall: float = 0.0,
        observer: rec.Observer | None = None,
    ) -> None:
        self._configuration, self._vehicle = configuration, vehicle
        self._store = WatchedStore(store, self._failed_write)
        self.judge = MissionValidator(vehicle, configuration.ascent_only)
        self._recorder, self._observer = recorder, observer or rec.Nobody()
        self.notice = self._observer.notice
        start = rec.Start(__version__, configuration, vehicle, store.content, wall, rec.FORM)
        self._record(rec.start_record, start, 0.0)
        self._clock = WallClock(wall, configuration.utc_offset)
        self._codec = vehicle_codec(*vehicle.speaks)
        self.meaning_of_no = self._codec.meaning_of_no
        self._gps, self._added, self._now = Receivers(), AddedDecoder(), 0.0
        links = configuration.links
        self._frontseat = line_to(self._codec, VEHICLE, links.vehicle, vehicle)
        self.gap, self.cannot_relay = self._frontseat.gap, self._frontseat.cannot_relay
        self._topside = OperatorServer(
            self,
            self._store,
            operator_channels(Tolerances.parse(configuration.tolerances), links.modem),
            DeviceSwitches(with_process(links)),
            configuration.answer_no,
        )
        self._engine = Engine(vehicle, forgotten_after=configuration.manual_for)
        self.output = self._engine.output
        self._engine.limit_topside_silence(configuration.topside_silence)
        self._chart: Chart | None = None
        self.situation = Situation(self._engine, vehicle, bool(links.gps or links.gps2))
        self._marker = ResumeMarker(self._store)
        self._standing = None if recorder is None else StandingChanges(recorder)
        self._out, self._refused = list[Tx](), list[Outcome]()  # refused: it cannot be encoded
        self._begin()
        if navigation is not None:
            self.set_navigation(navigation, 0.0)

    # --- calls of the event loop -------------------------------------------------------------

    def receive(self, rx: Rx, now: float | None = None) -> list[Tx]:
        """Take in bytes. ``now``: when the last of them came; ``rx.t``: the first."""
        self._now = now = max(self._now, rx.t if now is None else now)
        self._record(rec.rx_record, rx, now)
        if rx.link == VEHICLE:
            self._from_vehicle(self._codec.receive(rx.data, rx.t), now)
        elif rx.link in RECEIVERS:
            self._from_gps(self._gps.receive(rx), now, rx.link)
        elif rx.link == SENSORS:
            self._from_gps(self._added.receive(rx.data, rx.t), now, SENSORS)
        elif rx.link == NODES:
            self._topside.changed(rx.data, now)
        else:
            self._topside.receive(Peer(rx.link, rx.address), rx.data, now, rx.t)
        return self._leave(now)

    def connected(self, link: str, address: str, now: float) -> list[Tx]:
        """An operator has connected, or the vehicle's port is open again."""
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.CONNECTED, link, address)
        if link == VEHICLE:
            self._step(now, (LineOpened(),))
        else:
            self._topside.connected(Peer(link, address))
        return self._leave(now)

    def disconnected(self, link: str, address: str, now: float) -> list[Tx]:
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.DISCONNECTED, link, address)
        self._topside.disconnected(Peer(link, address), now)
        return self._leave(now)

    def handle_timer(self, now: float) -> list[Tx]:
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.TIMER)
        self._marker.handle_timer(now, self._frontseat.next_timer(), self._frontseat.halfway)
        if (due := self._codec.next_timer()) is not None and due <= now:
            self._from_vehicle(self._codec.flush(now), now)
        for link, heard in self._gps.flush(now):
            self._from_gps(heard, now, link)
        self._topside.handle_timer(now)
        if (due := self._engine.next_timer()) is not None and due <= now:
            self._step(now, ())
        return self._leave(now)

    def end(self, now: float, *, at_once: bool = False) -> list[Tx]:
        """The program has to end: once the engine is settled, or ``at_once`` with last commands."""
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.ENDING, *([rec.AT_ONCE] if at_once else []))
        self._step(now, (Ending(at_once),))
        return self._leave(now)

    def take_alarms(self, names: Sequence[str], now: float) -> list[Tx]:
        """Take in the alarms that serve alone sees, for @AE."""
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.ALARMS, ",".join(names))
        self.situation.of_serve = tuple(names)
        return self._leave(now)

    @property
    def said_all(self) -> bool:
        """Whether nothing waits to be sent to the vehicle, or for its acknowledgement."""
        return self._frontseat.said_all

    def next_timer(self) -> float | None:
        first = self._marker.next_timer()
        for due in (
            self._codec.next_timer(),
            self._gps.next_timer(),
            self._topside.next_timer(),
            self._frontseat.next_timer(),
            self._engine.next_timer(),
        ):
            if due is not None and (first is None or due < first):
                first = due
        return first

    def foresee(self, rx: Rx) -> tuple[str, ...]:
        """Return the lines of the mission that these bytes would complete, () if none. The event
        loop may give them to ``judge`` in a thread, before ``receive``. Changes nothing."""
        return self._topside.foresee(Peer(rx.link, rx.address), rx.data, rx.t)

    def make_navigation(self) -> Navigation:
        """Make the filter from recorded values alone. The imports take about a second, so call this
        in a thread, and pass the result to ``set_navigation``."""
        from mission.navigation import Navigation

        return Navigation(self._vehicle, date=self._clock.utc_date(0.0))

    def set_navigation(self, navigation: Navigation, now: float) -> list[Tx]:
        self._now = now = max(self._now, now)
        self._record(rec.input_record, now, rec.NAVIGATION)
        self._engine.attach(navigation)
        return self._leave(now)

    # --- in -----------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Start from the store. If something was under way, judge the stored mission later."""
        kept = self._store.content
        self.unjudged = kept.lines
        if not kept.under_way:
            self._judge_kept(0.0)
        self._step(0.0, (kept.limits, Restarted(kept.under_way)))

    def _judge_kept(self, now: float) -> None:
        lines, self.unjudged = self.unjudged, ()
        if lines:
            with contextlib.suppress(MissionRefused):  # @AQ shows it as refused
                self._load(self.judge(lines), now)

    def _from_vehicle(self, messages: Sequence[Received], now: float) -> None:
        inputs, heard = list[Input](), False
        for message in messages:
            if isinstance(message, FrameFault):
                self._record(rec.fault_record, now, VEHICLE, message)
            elif isinstance(message, Telemetry):
                self.situation.report(message)
                heard = True
                self._frontseat.report(message)
                inputs.append(message)
            elif message.group == "R":
                self._topside.relayed_answer(message, now)
            elif (outcome := self._frontseat.answer(message, now)) is not None:
                self._topside.order_outcome(outcome, now)
                inputs.append(outcome)
        if inputs:
            self._step(now, inputs)
            self.situation.locate()
        if heard and (estimate := self._engine.estimate) is not None:
            self._record(rec.estimate_record, estimate)
            self._observer.estimate(estimate)

    def _from_gps(self, heard: Sequence[Fix | Aid | FrameFault], now: float, link: str) -> None:
        for message in heard:
            if isinstance(message, FrameFault):
                self._record(rec.fault_record, now, link, message)
            else:
                if isinstance(message, Fix):
                    self.situation.take_fix(message)
                self._step(now, (message,))

    def _step(self, now: float, inputs: Sequence[Input]) -> tuple[Verdict, ...]:
        self._engine.hear_topside(self._topside.commander.heard_at)  # whatever the input was
        outputs = self._engine.step(now, inputs)
        for step in outputs.steps:
            self._record(rec.step_record, step)
            self.situation.note(step)
            self._observer.step(step)
        for action in outputs.actions:
            self.situation.commanded(action)
            if (refused := self._frontseat.command(action)) is not None:
                self._refused.append(refused)
        self._marker.follow(self._engine.under_way, now)
        return outputs.verdicts

    # --- out ----------------------------------------------------------------------------------

    def _leave(self, now: float) -> list[Tx]:
        navigation = self._engine.core.vehicle_state.navigation
        if navigation and self.unjudged and self.state.startswith("idle"):
            self._judge_kept(now)
        for _ in range(MOST_ROUNDS):
            sent, outcomes = self._frontseat.poll(now)
            self._out += sent
            if self._refused:
                outcomes, self._refused = outcomes + self._refused, []
            if not outcomes:
                break
            for outcome in outcomes:
                self._topside.order_outcome(outcome, now)
            self._step(now, outcomes)
        if self.situation.owes_report(now):
            self._topside.report_unasked(now, "at the surface")
        out = self._topside.outgoing(now)
        out, self._out = self._out + out, []
        for peer, fault in self._topside.faults():
            self._record(rec.fault_record, now, peer.link, fault)
        if self._standing is not None:
            self._standing.follow(now, self._engine, self.commander.peer, self.digest)
        for tx in out:
            self._record(rec.tx_record, tx)
        return out

    # --- what the operator server asks (CommandTarget) ------------------------------------------

    @property
    def state(self) -> str:
        return self._engine.state

    @property
    def under_way(self) -> str:
        return self._engine.under_way

    @property
    def engine(self) -> Engine:
        return self._engine  # for reading alone

    @property
    def commander(self) -> Commander:
        return self._topside.commander

    @property
    def digest(self) -> str:
        return self._chart.digest if self._chart else ""

    @property
    def doubted_at(self) -> float:
        return self._engine.doubted_at

    def decide(self, command: Command, now: float) -> Verdict:
        chart = self._chart if isinstance(command, StartMission) else None
        if chart is not None and (why := self._marker.foresee(chart.initial)):
            return Verdict(False, why)
        if isinstance(command, ClearMission):
            self._step(now, ())  # so that may_clear is of this instant
        clears = isinstance(command, ClearMission) and self._engine.may_clear
        if clears:  # durable first: if that fails, nothing is cleared
            try:
                self._store.keep_lines(())
            except StoreError as error:
                return Verdict(False, str(error))
            self.unjudged = ()
        verdict = self._step(now, (command,))[-1]
        if clears:
            self._load(None, now)
        return verdict

    def switch_auto(self, is_open: bool, now: float) -> None:
        self._step(now, (AutoNode(is_open),))

    def hear_stick(self, now: float) -> None:
        self._engine.hear_stick(now)

    def relay(self, frame: bytes, reason: str, manual: bool) -> str:
        self._engine.core.outputs.pass_by(channels_of(frame))
        return self._frontseat.relay(frame, reason, manual)

    def accept(self, lines: tuple[str, ...], now: float) -> None:
        chart = self.judge(lines)
        self._store.keep_lines(lines)
        self._load(chart, now)

    def status(self, now: float) -> Status:
        known = self.situation
        newest = known.telemetry.t if known.telemetry else now
        return Status(self._clock.local(newest), known.shown, known.telemetry)

    def condition(self, now: float) -> Condition:
        """What the runtime knows for the alarms."""
        return self.situation.condition(*self._topside.refusals.last, now, self._gps.trouble)

    def state_report(self, asker: Peer, now: float) -> StateReport:
        return self.situation.state_report(self.condition(now), asker, self.commander.at(now), now)

    def set_clock(self, time: str, now: float) -> None:
        self._clock.set(time, now)
        if self._configuration.set_system_clock:
            self._out.append(Tx(now, CLOCK, time.encode(), "operator @ST"))

    def _load(self, chart: Chart | None, now: float) -> None:
        self._chart, self.unjudged = chart, ()
        self._record(rec.mission_record, now, self.digest, self._store.content.lines)
        self._step(now, (Loaded(chart),))

    def _failed_write(self, number: int, why: str) -> None:
        self._record(rec.input_record, self._now, rec.STORE, str(number), why)

    def _record(self, make: Callable[..., Record], *values: object) -> None:
        if self._recorder is not None:
            self._recorder.record(make(*values))
