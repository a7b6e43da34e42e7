"""The laws of the runtime: what is durable when, what a restart does, what no input can break."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from links.base import Rx
from links.simulated.link import START, SimulatedVehicle
from links.simulated.settings import Settings as Sea
from mission.analysis.replay.replay import replay
from mission.authoring.language import parse, script
from mission.engine.restart import STICK, UNANSWERED, UNSEEN
from mission.model import STOPPED, SURFACED, SURFACING, Chart, Tx
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.navigation import Navigation
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.runtime.mission_validator import judge
from mission.onboard.runtime.records import (
    ESTIMATE,
    FAULT,
    RX,
    STEP,
    STORE,
    TIMER,
    ListRecorder,
    read_texts,
)
from mission.onboard.runtime.runtime import CLOCK, Runtime
from mission.onboard.serve.preload import prepare
from mission.onboard.store import MemoryStore, Stored, StoreError
from protocol.messages import MissionLine, SetSafety
from protocol.modem import Sender, wrap
from protocol.nmea import encode_gga, encode_rmc
from protocol.topside import encode

TEXT = """\
mission pool vehicle auv
safety radius 200 time 5min depth 5
start without fix
a: depth 2 heading 0 gear 4 for 20
"""
LINES = tuple(script(parse(TEXT)))
THREE = tuple(
    script(parse(TEXT + "b: depth 3 heading 90 gear 4 for 5\nc: depth 1 gear 4 heading 0 for 5\n"))
)
VEHICLE = replace(load_vehicle("auv"), dialect="documented")


class Boat:
    """A runtime with a simulated vehicle on its serial line, and what it sent."""

    def __init__(
        self,
        store: MemoryStore | None = None,
        navigation: bool = True,
        configuration: Configuration | None = None,
    ) -> None:
        self.store = store or MemoryStore()
        self.recorder = ListRecorder()
        self.sea = SimulatedVehicle("documented", 1)
        self.now = 0.0
        self.sent: list[Tx] = []
        self.runtime = Runtime(
            configuration or Configuration(),
            VEHICLE,
            self.store,
            self.recorder,
            wall=START.timestamp(),
        )
        if navigation:
            self.leave(self.runtime.set_navigation(self.runtime.make_navigation(), 0.0))
        self.leave(self.runtime.connected("topside", "boat", 0.0))

    def say(self, data: bytes) -> list[bytes]:
        before = len(self.sent)
        self.leave(self.runtime.receive(Rx(self.now, "topside", data, "boat")))
        return [tx.data for tx in self.sent[before:] if tx.link == "topside"]

    def upload(self) -> list[bytes]:
        total = len(LINES)
        return [self.say(encode(MissionLine(total, i + 1, t)))[0] for i, t in enumerate(LINES)]

    def until(self, end: float) -> None:
        link = self.sea.vehicle_link
        for _ in range(100_000):
            events = (link.next_event(), self.runtime.next_timer())
            due = max(self.now, min(t for t in events if t is not None))
            if due > end:
                self.now = end
                return
            self.now = due
            for rx in link.receive(due):
                self.leave(self.runtime.receive(rx, due))
            timer = self.runtime.next_timer()
            if timer is not None and timer <= due:
                self.leave(self.runtime.handle_timer(due))
        raise AssertionError("the runtime asks for a timer again and again")

    def leave(self, sent: list[Tx]) -> None:
        self.sent += sent
        for tx in sent:
            if tx.link == "vehicle":
                self.sea.vehicle_link.send(tx.data, self.now)

    def to_vehicle(self) -> list[bytes]:
        return [tx.data for tx in self.sent if tx.link == "vehicle"]

    def records(self, kind: str) -> list[dict[str, object]]:
        return [json.loads(record.payload) for record in self.recorder.of(kind)]


# --- durable ------------------------------------------------------------------------------------


def test_a_start_is_durable_before_its_first_command_leaves() -> None:
    boat = Boat()
    boat.upload()
    boat.until(4.0)
    assert boat.store.content.under_way == ""
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]
    assert boat.store.content.under_way.startswith("autonomous")


def test_a_stop_leaves_before_any_disk_is_asked() -> None:
    class SlowStore(MemoryStore):
        def keep_under_way(self, what: str) -> None:
            written.append(len(boat.to_vehicle()))
            super().keep_under_way(what)

    written: list[int] = []
    boat = Boat(SlowStore())
    boat.say(b"@ZAX0$")
    assert boat.to_vehicle() == [b"@ZAX0$"]
    assert written == []
    assert boat.runtime.next_timer() == boat.now
    boat.until(0.01)
    assert written == [1]
    assert boat.store.content.under_way == "emergency/stopped"


def test_no_disk_stands_before_a_stop_that_waits_for_the_line() -> None:
    store = Slow(Stored(), lambda: boat.to_vehicle())
    boat = Boat(store)
    boat.say(b"@MMF5$")
    boat.say(b"@ZAX0$")
    assert boat.to_vehicle() == [b"@MMF5$"]
    boat.until(1.0)
    assert store.before == [[b"@MMF5$", b"@ZAX0$"]]
    assert store.content.under_way == STOPPED


class FullDisk(MemoryStore):
    """Nothing can be made durable while ``full``."""

    full = False

    def keep_under_way(self, what: str) -> None:
        if self.full:
            raise StoreError("no space left on device")
        super().keep_under_way(what)

    def keep_lines(self, lines: tuple[str, ...]) -> None:
        if self.full:
            raise StoreError("no space left on device")
        super().keep_lines(lines)


def test_no_mission_starts_that_a_restart_would_not_know_of() -> None:
    store = FullDisk()
    boat = Boat(store)
    boat.upload()
    boat.until(4.0)
    store.full = True
    assert boat.say(b"@AA$") == [b"@ACK_AAN$"]
    assert boat.runtime.state == "idle/ready"
    store.full = False
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]
    assert store.content.under_way.startswith("autonomous")


def test_a_clear_is_durable_or_nothing_is_cleared() -> None:
    store = FullDisk()
    boat = Boat(store)
    boat.upload()
    store.full = True
    assert boat.say(b"@AC$") == [b"@ACK_ACN$"]
    assert boat.runtime.state == "idle/ready"
    assert boat.runtime.engine.chart is not None
    store.full = False
    assert boat.say(b"@AC$") == [b"@ACK_ACC$"]
    assert boat.runtime.state == "idle/empty"
    assert not store.content.lines


def test_a_start_that_is_refused_leaves_no_latch() -> None:
    boat = Boat(navigation=False)
    boat.upload()
    assert boat.say(b"@AA$") == [b"@ACK_AAN$"]
    assert boat.store.content.under_way == ""


def test_a_latch_that_the_disk_did_not_take_is_tried_until_it_does() -> None:
    store = FullDisk()
    boat = Boat(store)
    store.full = True
    boat.say(b"@ZAX0$")
    boat.until(12.0)
    assert store.content.under_way == ""
    store.full = False
    boat.until(20.0)
    assert store.content.under_way.startswith("emergency")


def test_the_latch_is_lifted_when_the_mission_is_over() -> None:
    boat = Boat()
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.until(120.0)
    assert boat.runtime.state == "idle/ready"
    assert boat.store.content.under_way == ""


@pytest.mark.parametrize("during", ["autonomous/a", "emergency/surfacing", "manual/driving", "?"])
def test_a_restart_under_way_surfaces_at_once(during: str) -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way=during)), navigation=False)
    assert boat.runtime.state == SURFACING
    boat.until(0.2)
    assert boat.to_vehicle() == [b"@ZAX0$", b"@ZAU12$"]


class Slow(MemoryStore):
    """Of each write of what is under way: the words that had left before it."""

    def __init__(self, content: Stored, said: Callable[[], list[bytes]]) -> None:
        super().__init__(content)
        self._said, self.before = said, list[list[bytes]]()

    def keep_under_way(self, what: str) -> None:
        self.before.append(list(self._said()))
        super().keep_under_way(what)


@pytest.mark.parametrize(
    "during", ["autonomous/a", "manual/driving", "emergency/stopped", STICK, UNANSWERED]
)
def test_no_disk_stands_before_the_first_word_of_a_restart(during: str) -> None:
    said: list[bytes] = []
    store = Slow(Stored(under_way=during), lambda: said)
    runtime = Runtime(Configuration(), VEHICLE, store)
    now = 0.0
    while now < 8.0:
        said += [tx.data for tx in runtime.handle_timer(now)]
        due = runtime.next_timer()
        now = max(now, 9.0 if due is None else due)
    assert all(b"@ZAX0$" in before for before in store.before)
    if during in ("autonomous/a", "manual/driving"):  # a way up, that a disk which hangs holds up
        assert b"@ZAU12$" in store.before[0]


def test_no_disk_stands_between_the_stop_of_an_ascent_and_its_way_up() -> None:
    """A heavy vehicle that sinks in idle, where the marker of an ascent is due at once."""
    store = Slow(Stored(), lambda: boat.to_vehicle())
    boat = Boat(store)
    body = replace(Sea().body, buoyancy=-4.0)
    boat.sea = SimulatedVehicle("documented", 1, replace(Sea(), body=body))
    boat.until(30.0)
    assert store.content.under_way == SURFACING
    assert store.before == [[b"@ZAX0$", b"@ZAU12$"]]


def test_no_disk_stands_within_the_words_of_a_legs_set() -> None:
    store = Slow(Stored(THREE), lambda: boat.to_vehicle())
    boat = Boat(store)
    boat.until(4.0)
    boat.say(b"@AA$")
    while boat.runtime.state != "autonomous/c":
        boat.until(boat.now + 0.5)
    boat.until(boat.now + 3.0)
    reasons = [tx.reason for tx in boat.sent if tx.link == "vehicle"]
    at_start, of_b, of_c = (reasons[: len(before)] for before in store.before)
    assert at_start == []
    assert of_b[-3:] == ["entry of b"] * 3
    assert of_c[-3:] == ["entry of c"] * 3


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """The lines of each mission that is judged."""
    found: list[tuple[str, ...]] = []

    def watched(lines: tuple[str, ...], vehicle: Vehicle) -> Chart:
        found.append(lines)
        return judge(lines, vehicle)

    monkeypatch.setattr("mission.onboard.runtime.mission_validator.judge", watched)
    return found


@pytest.mark.parametrize("during", [STICK, UNANSWERED, UNSEEN])
def test_a_stop_of_a_restart_waits_for_no_judge_of_the_stored_mission(
    during: str, judged: list[tuple[str, ...]]
) -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way=during)), navigation=False)
    boat.until(2.0)
    assert b"@ZAX0$" in boat.to_vehicle()
    assert (judged, boat.runtime.state) == ([], "idle/empty")
    navigation = prepare(boat.runtime)  # beside the loop
    assert judged == [LINES]
    boat.runtime.set_navigation(navigation, boat.now)
    assert (judged, boat.runtime.state) == ([LINES], "idle/ready")


@pytest.mark.parametrize("during", ["emergency/stopped", "emergency/surfaced"])
def test_a_restart_in_the_end_of_an_emergency_turns_nothing(during: str) -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way=during)), navigation=False)
    boat.until(30.0)
    assert boat.runtime.state == during
    assert set(boat.to_vehicle()) == {b"@ZAX0$"}


@pytest.mark.proof
def test_a_restart_names_the_leg_that_was_active() -> None:
    boat = Boat(MemoryStore(Stored(THREE)))
    boat.until(4.0)
    boat.say(b"@AA$")
    named = []
    while (now := boat.runtime.state) != "idle/ready":
        boat.until(boat.now + 0.5)
        if boat.runtime.state == now:  # no change in between
            next_one = Boat(MemoryStore(boat.store.content), navigation=False)
            assert next_one.runtime.engine.reason == f"the program restarted during {now}"
            named.append(now)
    assert {"autonomous/a", "autonomous/b", "autonomous/c"} <= set(named)


@pytest.mark.parametrize("during", [STOPPED, SURFACED])
def test_a_restart_where_everything_was_stopped_stops_it_again_and_stays(during: str) -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way=during)), navigation=False)
    boat.until(1.0)
    assert boat.runtime.state == during
    assert set(boat.to_vehicle()) == {b"@ZAX0$"}
    assert boat.store.content.under_way == during


def test_the_way_up_does_not_wait_for_the_judge_of_the_stored_mission(
    judged: list[tuple[str, ...]],
) -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way="autonomous/a")), navigation=False)
    boat.until(1.0)
    boat.runtime.set_navigation(prepare(boat.runtime), boat.now)
    boat.until(30.0)
    assert boat.to_vehicle()[:2] == [b"@ZAX0$", b"@ZAU12$"]
    assert judged == []
    boat.say(b"@MMF1$")
    boat.until(30.2)
    boat.say(b"@MMF1$")
    assert boat.runtime.state == "manual/driving"
    boat.until(100.0)
    assert boat.runtime.state == "idle/ready", "left by the stick it is there again"
    assert judged == [LINES]
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]


def test_a_check_that_fails_refuses_the_mission_and_says_its_fault(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(lines: tuple[str, ...], vehicle: Vehicle) -> Chart:
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr("mission.onboard.runtime.mission_validator.judge", broken)
    boat = Boat(MemoryStore())
    for i, line in enumerate(LINES, 1):
        answers = boat.say(encode(MissionLine(len(LINES), i, line)))
    assert answers == [b"@ACK_AWN$"]
    assert boat.runtime.state == "idle/empty"
    assert b"the check failed" in b"".join(boat.say(b"@AQ$"))
    assert b"ZeroDivisionError: float division by zero" in b"".join(boat.say(b"@AQ$"))


def test_a_mission_that_is_cleared_after_a_restart_is_not_there_again() -> None:
    boat = Boat(MemoryStore(Stored(LINES, under_way="autonomous/a")))
    boat.until(30.0)
    assert boat.say(b"@AC$") == [b"@ACK_ACC$"]
    assert boat.runtime.state == "idle/empty"
    assert boat.store.content.lines == ()


def test_a_restart_out_of_idle_has_the_stored_mission_ready() -> None:
    boat = Boat(MemoryStore(Stored(LINES)))
    assert boat.runtime.state == "idle/ready"
    boat.until(4.0)
    assert boat.to_vehicle() == []  # nothing is sent that nothing asked for
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]


def test_a_stored_mission_that_no_longer_compiles_is_not_ready() -> None:
    boat = Boat(MemoryStore(Stored(("mission x vehicle auv", "ZAF130"))))
    assert boat.runtime.state == "idle/empty"
    assert boat.say(b"@AA$") == [b"@ACK_AAN$"]


def test_limits_of_an_earlier_session_are_in_force_again() -> None:
    boat = Boat(MemoryStore(Stored(LINES, SetSafety(time=8.0))))
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.until(60.0)
    assert boat.runtime.state.startswith("emergency")


def test_a_disk_that_fails_does_not_stop_the_vehicle_and_is_on_record() -> None:
    boat = Boat(MemoryStore(failures={2: "no space left"}))
    boat.upload()
    boat.until(4.0)
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]
    boat.say(b"@ZAWF$")
    boat.until(10.0)
    assert boat.runtime.state.startswith("emergency")
    assert [read_texts(r) for r in boat.recorder.of(STORE)] == [("2", "no space left")]


def test_clearing_empties_the_store() -> None:
    boat = Boat()
    assert boat.upload()[-1] == b"@ACK_AWW$"
    assert boat.store.content.lines == LINES
    assert boat.say(b"@AC$") == [b"@ACK_ACC$"]
    assert boat.store.content.lines == ()
    assert boat.say(b"@AQ$")[0].startswith(b"@AR,empty,0,0,,,")


# --- navigation ----------------------------------------------------------------------------------


def test_a_start_waits_for_the_navigation() -> None:
    boat = Boat(navigation=False)
    boat.upload()
    boat.until(4.0)
    assert boat.say(b"@AA$") == [b"@ACK_AAN$"]
    navigation = boat.runtime.make_navigation()
    assert isinstance(navigation, Navigation)
    boat.runtime.set_navigation(navigation, boat.now)
    boat.until(8.0)
    assert boat.say(b"@AA$") == [b"@ACK_AAA$"]


def test_one_estimate_is_on_record_for_every_telemetry() -> None:
    boat = Boat()
    boat.until(20.0)
    reports = [r for r in boat.recorder.of(RX) if b"@SD" in r.payload]
    assert len(boat.records(ESTIMATE)) == len(reports) > 5


# --- time ------------------------------------------------------------------------------------------


def test_status_bears_the_time_of_the_newest_telemetry_in_local_time() -> None:
    boat = Boat()
    boat.until(1.5)
    assert boat.say(b"@DU$")[0].startswith(
        b"@VS2025-06-01-16:00:01,"
    )  # 08:00 UTC, first @SD at 1 s


def test_status_has_no_place_before_the_first_fix_and_keeps_the_last_one() -> None:
    boat = Boat()

    def place() -> list[bytes]:
        return boat.say(b"@DU$")[0].split(b",")[1:6]

    boat.until(3.5)
    assert place() == [b""] * 5
    utc = datetime(2025, 6, 1, 8, 0, 4, tzinfo=UTC)
    where = [math.radians(a) for a in (30.2874595, 120.1535765)]
    said = encode_gga(utc, *where) + encode_rmc(utc, *where, speed=1.0, course=0.5)
    boat.runtime.receive(Rx(boat.now, "gps", said))
    boat.until(5.0)
    fresh = place()
    assert fresh[:2] == [b"120.1535765", b"30.2874595"]
    assert b"" not in fresh
    boat.until(60.0)
    assert place() == fresh


def test_setting_the_time_moves_stamps_alone() -> None:
    boat = Boat()
    boat.until(3.5)
    assert boat.say(b"@ST,2030/02/03 04:05:06,$") == [b"@ACK_STT$"]
    boat.until(5.9)
    assert boat.say(b"@DU$")[0].startswith(b"@VS2030-02-03-04:05:07,")
    assert boat.now == 5.9
    assert [tx for tx in boat.sent if tx.link == CLOCK] == []


def test_the_systems_clock_is_set_where_configured() -> None:
    boat = Boat(configuration=Configuration(set_system_clock=True))
    boat.say(b"@ST,2030/02/03 04:05:06,$")
    assert [tx.data for tx in boat.sent if tx.link == CLOCK] == [b"2030-02-03T04:05:06"]


def test_time_that_goes_back_is_held() -> None:
    boat = Boat()
    boat.until(3.0)
    boat.runtime.handle_timer(1.0)
    boat.runtime.receive(Rx(0.5, "topside", b"@NI$", "boat"))
    times = [record.t for record in boat.recorder.records if record.kind in (TIMER, RX)]
    assert times == sorted(times)
    assert len(boat.recorder.of(TIMER)) > 0


# --- the vehicle's line -----------------------------------------------------------------------------


def test_power_is_relayed_and_its_answer_comes_back() -> None:
    boat = Boat()
    boat.until(0.5)
    boat.say(b"@RI$")
    boat.until(0.6)
    answers = [tx.data for tx in boat.sent if tx.link == "topside"]
    assert len(answers) == 1
    assert answers[0].startswith(b"@ACK_RI")
    assert len(answers[0]) == 9


def test_an_open_node_is_what_has_a_link() -> None:
    links = LinkUrls(gps=None, modem="serial:///dev/ttyUSB1")
    boat = Boat(configuration=Configuration(links=links))
    (answer,) = boat.say(b"@NI$")
    assert answer == b"@ACK_NI" + bytes([0b101011]) + b"$"


def test_closing_auto_ends_the_mission_and_holds_the_next_start() -> None:
    boat = Boat()
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.until(10.0)
    boat.say(b"@NSOOOOCC$")
    assert boat.runtime.state.startswith("idle")
    boat.until(10.1)
    assert boat.to_vehicle()[-1] == b"@ZAX0$"
    assert boat.say(b"@AA$") == [b"@ACK_AAN$"]


@pytest.mark.parametrize("asks", [True, False])
def test_a_silent_topside_is_a_limit_where_configured(asks: bool) -> None:
    boat = Boat(configuration=Configuration(topside_silence=8.0))
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    for i in range(5, 15):
        boat.until(float(i))
        if asks:
            boat.say(b"@DU$")
    assert boat.runtime.state == ("autonomous/a" if asks else SURFACING)


@pytest.mark.parametrize("head", [b"", b"#\x02\x40\x00\x01"])
def test_a_frame_that_the_clock_makes_whole_is_heard_from_topside(head: bytes) -> None:
    """G3: noise that looks like a content is given up, and what stood behind it is answered."""
    boat = Boat(configuration=Configuration(topside_silence=8.0))
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.leave(boat.runtime.connected("modem", "", boat.now))
    for i in range(2):
        boat.until(10.0 + 4.0 * i)
        content = head + wrap(b"@DU$", Sender.TOPSIDE)
        boat.leave(boat.runtime.receive(Rx(boat.now, "modem", content)))
    boat.until(16.0)
    assert len([tx for tx in boat.sent if tx.link == "modem"]) == 2
    assert boat.runtime.state == "autonomous/a"


@pytest.mark.parametrize("held", [b"@MMD12$", b"@MMD13$"])
def test_a_held_stick_takes_no_emergency_over_when_it_is_eased_into_its_range(held: bytes) -> None:
    boat = Boat()
    for i in range(60):
        boat.until(5.0 + 0.1 * i)
        boat.say(held)
        if i == 20:
            boat.say(b"@ZAWF$")
    boat.until(11.0)
    boat.say(b"@MMD12$")
    assert boat.runtime.state == SURFACING
    boat.until(13.0)
    boat.say(b"@MMD12$")
    boat.until(13.2)
    boat.say(b"@MMD12$")
    assert boat.runtime.state == "manual/driving"


# --- any bytes ----------------------------------------------------------------------------------------

FRAMES = [
    *(b"@AA$", b"@AC$", b"@AQ$", b"@DU$", b"@NI$", b"@ZAX0$", b"@ZAWF$", b"@RI$", b"@MMF5$"),
    *(b"@NSOOOOOC$", b"@NSOOOOOO$", b"@SP,100,5,3,10,$", b"@DS3,20$", b"@ST,2025/01/11 16:56:06,$"),
    *(encode(MissionLine(len(LINES), i + 1, text)) for i, text in enumerate(LINES)),
    *(b"@ACK_ZAY$", b"@ACK_ZAN$", b"@ACK_RI\x24$", b"@ACK_RSS$"),
]
LINKS = ("vehicle", "gps", "topside", "modem", "nodes")


@pytest.mark.proof
@given(
    st.lists(
        st.tuples(
            st.sampled_from(LINKS),
            st.one_of(st.sampled_from(FRAMES), st.binary(max_size=40)),
            st.sampled_from(["boat", "other"]),
            st.floats(0.0, 4.0),
        ),
        max_size=25,
    )
)
@settings(max_examples=60, deadline=None)
def test_no_input_on_any_link_breaks_the_drive(
    inputs: list[tuple[str, bytes, str, float]],
) -> None:
    boat = Boat()
    boat.upload()
    for link, data, address, wait in inputs:
        boat.leave(boat.runtime.receive(Rx(boat.now, link, data, address)))
        boat.until(boat.now + wait)
    assert all(tx.reason for tx in boat.sent)
    assert boat.runtime.state.split("/")[0] in ("idle", "autonomous", "manual", "emergency")


def test_garbage_is_on_record_as_faults() -> None:
    boat = Boat()
    boat.say(b"@XX$garbage")
    boat.until(1.0)
    assert boat.recorder.of(FAULT)


def test_every_step_on_record_says_what_came_in() -> None:
    boat = Boat()
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.until(60.0)
    steps = boat.records(STEP)
    assert len(steps) > 3
    assert all(step["event"] for step in steps)


@pytest.mark.parametrize("name", ["rov", "coreboard", "robot"])
def test_a_board_that_answers_nothing_hears_the_stop_again_and_again(name: str) -> None:
    runtime = Runtime(Configuration(), load_vehicle(name), MemoryStore())
    sent = runtime.receive(Rx(1.0, "topside", b"@ZAX0$", "boat"))
    for _ in range(20):
        due = runtime.next_timer()
        assert due is not None
        sent += runtime.handle_timer(max(due, 1.0))
    to_vehicle = [tx for tx in sent if tx.link == "vehicle" and "outputs in" not in tx.reason]
    assert len({tx.data for tx in to_vehicle}) <= 2
    assert len(to_vehicle) > 10
    assert runtime.state == "emergency/stopped"


def test_what_is_due_leaves_though_a_receiver_that_says_nothing_comes_first() -> None:
    """Under water its sentences are news to nobody; an instant that somebody waits for is one."""
    runtime = Runtime(Configuration(), VEHICLE, MemoryStore())
    assert runtime.receive(Rx(1.0, "topside", b"@ZAX0$", "boat"))
    runtime.handle_timer(1.0)  # the marker's
    due = runtime.next_timer()
    assert due is not None
    nothing = encode_gga(START, None, None)
    assert not runtime.receive(Rx(due - 0.1, "gps", nothing))
    assert runtime.next_timer() == due
    again = runtime.receive(Rx(due, "gps", nothing))
    assert [(tx.link, tx.data) for tx in again] == [("vehicle", b"@ZAX0$")]


# --- a line that was away ------------------------------------------------------------------------


def test_behind_a_line_that_was_away_what_was_stopped_is_stopped_again() -> None:
    """Whoever acknowledged the stop need not have been the vehicle; in idle none turns either."""
    for state, order in (("idle/empty", b""), ("emergency/stopped", b"@ZAX0$")):
        boat = Boat()
        boat.until(4.0)
        boat.say(order)
        boat.until(8.0)
        assert boat.runtime.state == state
        before = boat.to_vehicle()
        boat.leave(boat.runtime.connected("vehicle", "", 8.0))
        assert boat.to_vehicle()[len(before) :] == [b"@ZAX0$"]
        boat.until(12.0)
        assert boat.to_vehicle()[len(before) :] == [b"@ZAX0$"]  # acknowledged, and no more
        assert boat.runtime.state == state
        assert replay(boat.recorder.records).identical


def test_behind_a_line_that_was_away_a_leg_says_its_whole_set_again() -> None:
    boat = Boat()
    boat.upload()
    boat.until(4.0)
    boat.say(b"@AA$")
    boat.until(8.0)
    assert boat.runtime.state.startswith("autonomous/")
    before = len(boat.sent)
    boat.leave(boat.runtime.connected("vehicle", "", boat.now))
    boat.until(boat.now + 3.0)
    again = [tx for tx in boat.sent[before:] if tx.link == "vehicle"]
    first = [tx.data for tx in boat.sent[:before] if tx.link == "vehicle"]
    assert [tx.data for tx in again] == first[-len(again) :]
    assert len(again) >= 2
    assert all("the line to the vehicle was away" in tx.reason for tx in again)


def test_behind_a_line_that_was_away_an_ascent_says_its_way_again() -> None:
    """At once, and its turn ends when it would have ended."""
    boat = Boat()
    boat.until(4.0)
    boat.say(b"@ZAWF$")
    boat.until(8.0)
    assert boat.runtime.state == "emergency/surfacing"
    before = boat.to_vehicle()
    boat.leave(boat.runtime.connected("vehicle", "", 8.0))
    assert boat.to_vehicle()[len(before) :] == [b"@ZAWF$"]
    assert "the line to the vehicle was away" in boat.sent[-1].reason
    assert replay(boat.recorder.records).identical


def test_the_stick_is_not_disturbed_by_a_line_that_was_away() -> None:
    boat = Boat()
    boat.until(4.0)
    boat.say(b"@MMF5$")
    before = boat.to_vehicle()
    boat.leave(boat.runtime.connected("vehicle", "", 4.5))
    boat.until(5.5)
    assert boat.to_vehicle() == before
