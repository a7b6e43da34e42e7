"""Success of X and W is said only where a report has shown it; over every vehicle's own bytes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import pytest
from click.testing import CliRunner

from links.base import Rx
from links.simulated.boards import SimulatedBoard
from links.simulated.link import SimulatedVehicle
from links.simulated.settings import parse_settings
from mission.authoring.language import parse, script
from mission.cli import main
from mission.model import SURFACED, SURFACING, Tx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore, Stored
from mission.topside import console
from mission.topside.orders import LOOKS, WORDS, Contradicted, Unconfirmed, order
from mission.topside.underwater import Submerged
from mission.topside.upload import Conversation, NoAnswer, OperatorError
from protocol.arq import Acoustics
from protocol.messages import (
    Ack,
    DataQuery,
    Emergency,
    Order,
    StateQuery,
    StateReport,
    Status,
    StoreReport,
    Telemetry,
)
from protocol.modem import Sender, wrap
from protocol.topside import encode

ON, OFF = (0.5, 0.5, 0.0, 0.0, 0.0, 0.2, 0.2), (0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.2)
STORE = StoreReport("running", 0, 0, "", "", "")
TAKEN = {
    Order.STOP: Ack(0.0, "Z", "X", ord("Y")),
    Order.SURFACE: Ack(0.0, "Z", "W", ord("Y")),
}


def seen(second: int, depth: float | None = None, actuators: tuple[float, ...] = ()) -> Status:
    report = Telemetry(0.0, depth=depth, actuators=actuators or None)
    return Status(f"2025-01-01T00:00:{second:02}", None, report)


def ordered(
    which: Order,
    told: Sequence[Status | None],
    store: StoreReport = STORE,
    states: tuple[StateReport | None, ...] = (None,),
) -> str:
    """What is said in the end, where the reports and states are these, None where no answer comes;
    the last of them stays."""
    reports, tells = iter(told), iter(states)
    last, state = told[0], states[0]
    talk = order(which)
    ask = next(talk)
    try:
        while True:
            if isinstance(ask.command, Emergency):
                ask = talk.send(TAKEN[which])
            elif isinstance(ask.command, DataQuery):
                last = next(reports, last)
                ask = talk.send(last)
            elif isinstance(ask.command, StateQuery):
                state = next(tells, state)
                ask = talk.send(state)
            else:
                ask = talk.send(store if ask.fits(store) else None)
    except StopIteration as end:
        return str(end.value)


def test_a_stop_is_confirmed_by_a_later_report_with_every_thruster_off() -> None:
    said = ordered(Order.STOP, [seen(0, 3.0, ON), seen(2, 3.0, ON), seen(4, 3.0, OFF)])
    assert said == "stop: its report shows every thruster off"


def test_a_report_from_before_the_stop_confirms_nothing() -> None:
    with pytest.raises(Unconfirmed, match="no report of the vehicle has come since"):
        ordered(Order.STOP, [seen(0, 3.0, OFF)])


@pytest.mark.parametrize("which", list(Order))
def test_where_the_first_question_has_no_answer_one_report_confirms_nothing(which: Order) -> None:
    before = seen(0, 0.3, OFF)
    with pytest.raises(Unconfirmed, match="no report of the vehicle has come since"):
        ordered(which, [None, None, before])
    assert ordered(which, [None, before, before, seen(2, 0.3, OFF)]).startswith(WORDS[which])


def test_a_stop_that_the_reports_contradict_is_none() -> None:
    told = [seen(second, 3.0, ON) for second in range(0, 40, 2)]
    with pytest.raises(Contradicted, match=r"thrusters on \(\+50 \+50 \+0 \+0 \+0 %\)"):
        ordered(Order.STOP, told)


def test_where_no_thruster_is_reported_a_stop_is_sent_and_not_confirmed() -> None:
    with pytest.raises(Unconfirmed, match="stop was sent, and nothing confirms it"):
        ordered(Order.STOP, [seen(0, 3.0), seen(2, 3.0), seen(4, 3.0)])


@pytest.mark.parametrize("actuators", [(), OFF])
def test_what_the_vehicles_program_holds_against_a_stop_counts(
    actuators: tuple[float, ...],
) -> None:
    report = replace(STORE, refusal="X: a report shows way after the stop")
    with pytest.raises(Contradicted, match="a report shows way after the stop"):
        ordered(Order.STOP, [seen(0), seen(2, None, actuators)], report)


@pytest.mark.parametrize(
    ("depths", "words"),
    [
        ([0.3, 0.3], "0.3 m: at the surface"),
        ([5.0, 5.4, 5.2, 4.8], "rises: 5.4 m deep, then 4.8 m"),
    ],
)
def test_surfacing_is_confirmed_by_the_surface_or_by_a_depth_that_falls(
    depths: list[float], words: str
) -> None:
    said = ordered(Order.SURFACE, [seen(2 * i, depth) for i, depth in enumerate(depths)])
    assert words in said


def in_state(state: str, to_depth_m: float | None) -> StateReport:
    nothing = (None,) * 5
    rest = (to_depth_m, None, None, None)
    return StateReport(state, "asker", *nothing, *rest, alarms=0, setpoint="", leg="")


@pytest.mark.parametrize("depths", [[5.9, 0.2, 0.2], [5.9, 4.9, 3.9]])
def test_a_depth_that_the_vehicles_program_does_not_believe_confirms_no_ascent(
    depths: list[float],
) -> None:
    told = [seen(2 * i, depth) for i, depth in enumerate(depths)]
    with pytest.raises(Unconfirmed, match="does not believe the depth that it reports"):
        ordered(Order.SURFACE, told, states=(in_state(SURFACING, None),))
    doubted_at_first = in_state(SURFACING, None), in_state(SURFACED, 30.0)
    told = [seen(0, 5.9), seen(2, 0.2), seen(4, 0.2)]
    assert "at the surface" in ordered(Order.SURFACE, told, states=doubted_at_first)


def test_the_surface_is_confirmed_once_the_vehicles_program_has_proved_it() -> None:
    told = [seen(second, 0.3) for second in range(6)]
    with pytest.raises(Unconfirmed, match="has not proved the surface so far"):
        ordered(Order.SURFACE, told, states=(in_state(SURFACING, 30.0),))
    by_fix = in_state(SURFACING, None), in_state(SURFACED, None)
    assert "at the surface" in ordered(Order.SURFACE, told, states=by_fix)


@pytest.mark.parametrize("state", [None, in_state(SURFACING, 30.0), in_state(SURFACED, None)])
def test_above_the_water_is_no_surface(state: StateReport | None) -> None:
    with pytest.raises(Unconfirmed, match=r"shows -3\.1 m, which is no depth"):
        ordered(Order.SURFACE, [seen(0, 5.9), seen(2, -3.1)], states=(state,))


def test_surfacing_without_a_depth_that_falls_is_none() -> None:
    told = [seen(second, 5.0 + 0.01 * second) for second in range(59)]
    with pytest.raises(Contradicted, match=r"its depth does not fall: 5\.0 m, now 5\.3 m"):
        ordered(Order.SURFACE, told)
    with pytest.raises(Unconfirmed, match="no depth is reported"):
        ordered(Order.SURFACE, [seen(0), seen(2), seen(4)])


@pytest.mark.parametrize(
    ("which", "other"), [(Order.STOP, Order.SURFACE), (Order.SURFACE, Order.STOP)]
)
def test_the_answer_to_another_order_is_none_to_this_one(which: Order, other: Order) -> None:
    """It may have been on its way when this one took the other's place."""
    talk = Conversation(order(which))
    said = talk.begin(0.0)
    assert talk.receive(encode(TAKEN[other]), 0.5) == []
    assert talk.handle_timer(1.0) == said
    assert talk.receive(encode(TAKEN[which]), 1.5) == [b"@DU$"]


@pytest.mark.parametrize(
    ("which", "other"), [(Order.STOP, Order.SURFACE), (Order.SURFACE, Order.STOP)]
)
def test_by_modem_the_answer_to_another_order_is_none_either(which: Order, other: Order) -> None:
    talk, patience = Submerged(order(which, under_water=True), Acoustics(800.0, 600.0)), 60.0
    said = talk.begin(0.0)
    assert talk.receive(wrap(encode(TAKEN[other]), Sender.VEHICLE), 0.5) == []
    assert talk.handle_timer(patience) == said
    heard = talk.receive(wrap(encode(TAKEN[which]), Sender.VEHICLE), patience + 0.5)
    assert heard == [wrap(b"@DU$", Sender.TOPSIDE)]


def test_what_is_looked_at_is_told_before() -> None:
    told: list[str] = []
    talk = order(Order.STOP, told.append)
    next(talk)
    talk.send(TAKEN[Order.STOP])
    assert told == ["stop: the vehicle has it; what its reports show is looked at now"]


# --- over the bytes of every vehicle --------------------------------------------------------------

AHEAD = {
    "auv": "a: depth 3 heading 0 gear 6 for 5min",
    "coreboard": "a: depth 3 heading 0 gear 6 for 5min",
    "rov": "a: gear 6 down 6 for 40s",
    "robot": "a: gear 6 for 60s",
}


class Sea:
    """A mission under way; ``deaf``: the board goes on with what it heard last before that."""

    def __init__(self, name: str, *settings: str, depth: int = 3) -> None:
        text = f"mission m vehicle {name}\nsafety time 20min\nassume start 0\nstart without fix\n"
        lines = tuple(script(parse(text + AHEAD[name].replace("depth 3", f"depth {depth}"))))
        vehicle = load_vehicle(name)
        self.sea = (
            SimulatedVehicle("as-built", 1, parse_settings(settings))
            if name == "auv"
            else SimulatedBoard(name, 1)
        )
        self.runtime = Runtime(Configuration(), vehicle, MemoryStore(Stored(lines)))
        self.runtime.set_navigation(self.runtime.make_navigation(), 0.0)
        self.now, self.deaf, self.kept = 0.0, False, b""
        self.sent: list[Tx] = []
        self.run(4.0)
        assert self.say(b"@AA$") == b"@ACK_AAA$"
        self.run(12.0)

    def say(self, frame: bytes) -> bytes:
        return self.out(self.runtime.receive(Rx(self.now, "topside", frame, "boat")))

    def out(self, sent: list[Tx]) -> bytes:
        """What the boat is told."""
        self.sent += sent
        for tx in sent:
            if tx.link == "vehicle":
                self.kept = self.kept if self.deaf else tx.data
                self.sea.vehicle_link.send(self.kept, self.now)
        return b"".join(tx.data for tx in sent if tx.link == "topside")

    def run(self, seconds: float, talk: Conversation | None = None) -> None:
        end, link = self.now + seconds, self.sea.vehicle_link
        while talk is None or not talk.over:
            dues = [
                link.next_event(),
                self.runtime.next_timer(),
                talk.next_timer() if talk else None,
            ]
            self.now = max(self.now, min(t for t in dues if t is not None))
            if self.now > end:
                self.now = end
                return
            heard = b"".join([self.out(self.runtime.receive(rx)) for rx in link.receive(self.now)])
            due = self.runtime.next_timer()
            if due is not None and due <= self.now:
                heard += self.out(self.runtime.handle_timer(self.now))
            if talk is not None:
                self._tell(talk, talk.receive(heard, self.now))
                self._tell(talk, talk.handle_timer(self.now))

    def _tell(self, talk: Conversation, frames: list[bytes]) -> None:
        for frame in frames:
            self._tell(talk, talk.receive(self.say(frame), self.now))

    def order(self, which: Order, looked: float = 200.0) -> Conversation:
        talk = Conversation(order(which))
        self._tell(talk, talk.begin(self.now))
        self.run(looked, talk)
        return talk

    def times(self, reason: str) -> int:
        """That it was said anew, not held."""
        return sum(tx.reason.endswith(reason) for tx in self.sent if tx.link == "vehicle")


@pytest.mark.parametrize("name", AHEAD)
def test_a_stop_that_is_obeyed_is_confirmed_where_thrusters_are_reported(name: str) -> None:
    sea = Sea(name)
    talk = sea.order(Order.STOP)
    if name in ("auv", "rov"):
        assert talk.result == "stop: its report shows every thruster off"
    else:
        assert isinstance(talk.failure, Unconfirmed)
        assert "no thrusters are reported" in str(talk.failure)
    assert sea.times("after it was stopped") == 0


@pytest.mark.parametrize("name", ["rov", "robot", "coreboard"])
def test_a_board_that_is_deaf_to_a_stop_is_never_called_stopped(name: str) -> None:
    sea = Sea(name)
    sea.deaf = True
    talk = sea.order(Order.STOP)
    assert talk.result is None
    if name == "coreboard":  # it reports neither thrusters nor speed
        assert isinstance(talk.failure, Unconfirmed)
        return
    assert isinstance(talk.failure, Contradicted)
    assert sea.times("after it was stopped") >= 2, "repeated, with its reason"
    report = sea.say(b"@AQ$")
    assert b"X: a report shows way after the stop" in report


def test_a_stop_that_is_obeyed_late_is_no_longer_doubted() -> None:
    sea = Sea("robot")
    sea.deaf = True
    sea.order(Order.STOP)
    sea.deaf = False
    sea.run(20.0)
    before = sea.times("after it was stopped")
    assert b"way after the stop" not in sea.say(b"@AQ$")
    sea.run(20.0)
    assert sea.times("after it was stopped") == before


@pytest.mark.parametrize("off", [9.0, 5.8])
def test_a_sensor_that_comes_loose_under_water_confirms_no_ascent(off: float) -> None:
    """6 m deep it says that it is above the water, or just under its surface."""
    sea = Sea("auv", f"fault=depth_too_shallow={off}@60", depth=6)
    sea.run(63.5 - sea.now)
    talk = sea.order(Order.SURFACE, looked=5.0)
    assert sea.sea.truth().depth > 5.0
    assert talk.result is None


@pytest.mark.parametrize("name", ["auv", "coreboard", "rov"])
def test_surfacing_that_is_obeyed_is_confirmed_by_the_depth(name: str) -> None:
    talk = Sea(name).order(Order.SURFACE)
    assert talk.failure is None
    assert talk.result is not None
    assert "rises" in talk.result or "at the surface" in talk.result


# --- the command ----------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [WORDS[which] for which in LOOKS])
@pytest.mark.parametrize(
    ("failure", "code"),
    [(None, 0), (Unconfirmed("sent"), 3), (Contradicted("sent, but"), 1), (NoAnswer("none"), 1)],
)
def test_the_exit_code_says_what_was_confirmed(
    command: str, failure: OperatorError | None, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def converse(url: str, talk: Iterator[object]) -> str:
        if failure is not None:
            raise failure
        return "shown"

    monkeypatch.setattr(console, "converse", converse)
    ran = CliRunner().invoke(main, [command])
    assert ran.exit_code == code
    assert (ran.stdout, ran.stderr) == (("shown\n", "") if code == 0 else ("", f"{failure}\n"))
