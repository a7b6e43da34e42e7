"""The read-only monitor: everything is shown, new, on any way; nothing is commanded; it costs little."""

from __future__ import annotations

import asyncio
import itertools
import json
import socket
import time
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from served import PATIENCE, running, silent_board, simulated, soon

from links import open_link
from links.base import LinkError
from mission.commands.monitor import monitor as monitor_command
from mission.onboard.serve import viewing
from mission.onboard.serve.journal import OF_A_KIND
from mission.onboard.serve.keys import make_keys
from mission.onboard.serve.listening import listening_to_viewers
from mission.onboard.serve.monitor import EVENTS, SILENT_S, TRACK, Monitor, Track, Unwelcome
from mission.topside.monitor import SPARE, NoMonitor, Watched, wish
from mission.topside.monitor import TRACK as KEPT

STATE = {"state": "idle/ready", "depth": 0.25, "alarms": [], "leg": ""}
BOAT = "10.0.0.2:1"


class Show:
    """A monitor with one viewer at the other end of any way."""

    def __init__(self, **wished: Any) -> None:
        self.monitor, self.watched, self.now = Monitor(), Watched(), 0.0
        self.monitor.connected(BOAT, 0.0)
        self.monitor.receive(BOAT, wish(**wished), 0.0)

    def send(self, state: dict[str, Any]) -> bytes:
        return self.monitor.frame(BOAT, state, self.now, self.now)

    def answer(self, frame: bytes) -> None:
        _, answers = self.watched.receive(frame, self.now)
        self.monitor.receive(BOAT, answers, self.now)

    def settle(self, state: dict[str, Any]) -> list[bytes]:
        """All frames until nothing is left to be said."""
        frames = []
        for _ in range(1000):
            self.now += 10.0
            frame = self.send(state)
            if not frame:
                return frames
            frames.append(frame)
            self.answer(frame)
        raise AssertionError("there is no end of it")


VALUES = st.dictionaries(
    st.sampled_from(["state", "depth", "leg", "alarms", "current"]),
    st.none() | st.floats(-1e6, 1e6) | st.text(max_size=30) | st.lists(st.integers(), max_size=4),
)


@pytest.mark.proof
@given(states=st.lists(VALUES, min_size=1, max_size=6), most=st.integers(200, 3000))
@settings(max_examples=100, deadline=None)
def test_whatever_changes_a_viewer_ends_with_the_vehicles_own_state(
    states: list[dict[str, Any]], most: int
) -> None:
    show, whole = Show(most=most), dict[str, Any]()
    for state in states:
        whole |= state
        show.settle(whole)
    assert show.watched.state == whole


def test_three_frames_at_most_are_unanswered_and_the_newest_replaces_what_waits() -> None:
    show = Show()
    sent = [show.send(STATE)]
    while show.monitor.due(show.now) or show.now < 60.0:
        show.now += 0.5
        if show.monitor.due(show.now):
            sent.append(show.send({**STATE, "depth": show.now}))
    assert len(sent) == 3
    for frame in sent:
        show.answer(frame)
    assert show.monitor.due(show.now) == [BOAT]
    show.answer(show.send({**STATE, "depth": 99.0}))
    assert show.watched.state["depth"] == 99.0


def test_over_a_long_way_a_frame_leaves_before_the_last_is_answered() -> None:
    show = Show()
    first = show.send(STATE)
    show.now = 2.0
    show.answer(first)
    second = show.send({**STATE, "depth": 1.0})
    show.now = 2.9
    assert show.monitor.due(show.now) == []
    show.now = 3.0  # half a way there and back
    assert show.monitor.due(show.now) == [BOAT]
    third = show.send({**STATE, "depth": 2.0})
    show.answer(second + third)
    assert show.watched.state["depth"] == 2.0


def test_beside_the_state_a_late_answer_has_less_told_and_a_quick_one_more() -> None:
    show = Show()
    for n in range(200):
        show.monitor.event(f"{n} s info: now here, and on the way to the next of the rows")
    sizes = []
    for n, took in enumerate((0.1, 0.1, 0.1, 2.0, 2.0, 2.0)):
        show.now += 1.0
        frame = show.send({**STATE, "depth": n})
        sizes.append(len(frame))
        show.now += took
        show.answer(frame)
    assert sizes[0] < sizes[1] < sizes[2] < sizes[3] > sizes[4] > sizes[5]


def test_a_frame_holds_no_more_than_was_wished_and_states_come_before_the_track() -> None:
    show = Show(most=300)
    show.monitor.load(f"leg{i}: depth {i}" for i in range(40))
    for i in range(200):
        show.monitor.track.add(float(i), 30.0 + i * 1e-5, 120.0, 1.0)
    frames = show.settle(STATE)
    assert json.loads(frames[0])["state"] == STATE
    assert max(map(len, frames)) <= 600
    assert sum(map(len, frames)) / len(frames) > 200
    assert show.watched.plan == tuple(f"leg{i}: depth {i}" for i in range(40))
    assert [point[0] for point in show.watched.track] == [float(i) for i in range(200)]


def test_a_state_is_useful_at_a_thousand_bits_a_second() -> None:
    """What a thin radio carries in a second holds the state, the depth and their time."""
    show = Show(most=300, values=("state", "depth", "report_at"), track=False, plan=False)
    show.settle({**STATE, "report_at": 1.0})
    (frame,) = show.settle({**STATE, "depth": 2.5, "report_at": 2.0})
    assert len(frame) <= 1000 / 8
    assert show.watched.state == {"state": "idle/ready", "depth": 2.5, "report_at": 2.0}


def test_the_rate_is_the_viewers_wish() -> None:
    show = Show(rate=0.5)
    show.answer(show.send(STATE))
    assert show.monitor.due(1.9) == []
    assert show.monitor.due(2.0) == [BOAT]


def test_events_wait_up_to_a_bound_and_a_gap_is_told() -> None:
    show = Show(most=60_000)
    show.settle(STATE)
    for number in range(EVENTS + 7):
        show.monitor.event(f"event {number}")
    show.settle(STATE)
    assert show.watched.gap == 7
    assert list(show.watched.events) == [f"event {n}" for n in range(7, EVENTS + 7)]


def test_who_comes_later_sees_what_happened_before() -> None:
    show = Show()
    show.monitor.event("before")
    show.monitor.load(["a", "b"])
    show.monitor.connected("late:1", 0.0)
    show.monitor.receive("late:1", wish(), 0.0)
    said = json.loads(show.monitor.frame("late:1", STATE, 1.0, 1.0))
    assert (said["events"], said["plan"]) == (["before"], ["", "a", "b"])


def test_a_long_track_is_thinned_and_every_viewer_has_it_to_its_end() -> None:
    track = Track()
    for i in range(3 * TRACK):
        track.add(float(i), 30.0, 120.0, None)
    assert len(track.points) <= TRACK
    assert track.points[0][0] == 0.0
    assert track.points[-1][0] >= 3 * TRACK - 4.0
    show = Show()
    for i in range(2 * TRACK):
        show.monitor.track.add(float(i), 30.0, 120.0, None)
        if i == TRACK // 2:
            show.settle(STATE)
    show.settle(STATE)
    times = [point[0] for point in show.watched.track]
    assert times == sorted(times)
    assert times[-1] == show.monitor.track.points[-1][0]
    assert max(later - sooner for sooner, later in itertools.pairwise(times)) <= 4.0, "no hole"


def reported(t: float) -> dict[str, Any]:
    return {**STATE, "report_at": t, "battery": 12.0 - t / 1e4}


def test_who_comes_later_is_told_what_the_values_were_the_newest_first() -> None:
    show = Show(past="before", most=600)
    for t in range(300):
        show.monitor.past.take(reported(float(t)))
    show.monitor.receive(BOAT, wish(past="before", most=600), 0.0)
    frames = [json.loads(frame) for frame in show.settle(STATE)]
    told = [row[0] for frame in frames for row in frame.get("past", ())]
    assert told == [float(t) for t in reversed(range(300))]
    assert show.watched.past.rows == show.monitor.past.rows


def test_what_comes_later_is_in_the_state_and_not_told_twice() -> None:
    show = Show(past="before")
    for t in range(5):
        show.monitor.past.take(reported(float(t)))
        assert all("past" not in json.loads(frame) for frame in show.settle(reported(float(t))))
    assert show.watched.past.rows == show.monitor.past.rows


def test_behind_a_fault_of_the_program_the_track_goes_on_and_the_past_is_the_new_engines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(viewing, "TRACK_S", 0.0)
    seen: list[float] = []
    place = {"latitude": 30.0, "longitude": 120.0}
    show = viewing.Viewing(
        "memory://x", lambda: (seen[-1], {**reported(seen[-1]), **place}, ()), lambda _: None
    )

    async def flown() -> None:
        looking = asyncio.get_running_loop().create_task(show.keep())
        for t in (100.0, 160.0, 1.0, 21.0):
            seen.append(t)
            while not show.monitor.track.points or show.monitor.track.points[-1][0] != t:
                await asyncio.sleep(0.01)
        looking.cancel()

    asyncio.run(asyncio.wait_for(flown(), PATIENCE))
    assert [point[0] for point in show.monitor.track.points] == [100.0, 160.0, 1.0, 21.0]
    assert [row[0] for row in show.monitor.past.rows] == [1.0, 21.0]


def test_who_looks_on_all_along_is_told_the_past_of_another_engine_from_its_begin() -> None:
    show, told = Show(past="all"), list[float]()
    for begin in (100.0, 0.0):
        show.monitor.begin_again()
        for n in range(5):
            show.monitor.past.take(reported(begin + n))
            frames = map(json.loads, show.settle(reported(begin + n)))
            told += [row[0] for frame in frames for row in frame.get("past", ())]
    assert told == [begin + n for begin in (100.0, 0.0) for n in range(5)]


def test_who_wishes_for_no_past_is_told_none() -> None:
    show = Show()
    show.monitor.past.take(reported(1.0))
    show.monitor.receive(BOAT, wish(), 0.0)
    assert all(b"past" not in frame for frame in show.settle(STATE))


@pytest.mark.parametrize("rows", ['[["a"]]', "[1]", "[[1.0]]"])
def test_a_past_that_is_none_is_no_monitors(rows: str) -> None:
    with pytest.raises(NoMonitor):
        Watched().receive(b'{"n": 1, "t": 1.0, "past": %s}\n' % rows.encode(), 0.0)


def test_who_does_not_read_for_20_s_is_sent_away_and_who_reads_stays() -> None:
    show = Show()
    show.monitor.connected("mute:1", 0.0)
    first = show.send(STATE)
    assert show.monitor.silent(SILENT_S) == []
    assert show.monitor.silent(SILENT_S + 0.1) == [BOAT, "mute:1"]
    show.answer(first)
    assert show.monitor.silent(1000.0) == ["mute:1"]


@pytest.mark.parametrize(
    "said",
    [b"@ZAX0$\n", b"@AA$\n", b'{"stop": true}\n', b"[]\n", b"3\n", b"\xff\n", b'{"wish": 3}\n', b'{"wish": []}\n',
     b'{"wish": {"go": 1}}\n', b'{"wish": {"values": [1]}}\n', b'{"wish": {"rate": "x"}}\n',
     b'{"wish": {"bytes": Infinity}}\n',
     b'{"ack": 99}\n', b"x" * 5000, b"[" * 4000 + b"\n"],
)  # fmt: skip
def test_who_says_anything_else_is_sent_away(said: bytes) -> None:
    show = Show()
    with pytest.raises(Unwelcome):
        show.monitor.receive(BOAT, said, 0.0)


def test_a_client_knows_what_is_no_monitor() -> None:
    odd = [b'{"n":1,"t":0.0,"%s":7.5}\n' % name for name in (b"state", b"events", b"track", b"gap")]
    for said in (b"@ACK_AAN$\n", b"{}\n", b"[]\n", b"x" * (1 << 21), *odd):
        with pytest.raises(NoMonitor):
            Watched().receive(said, 0.0)


def test_a_frame_that_was_cut_off_spoils_none_of_the_next_connection() -> None:
    watched = Watched()
    assert watched.receive(b'{"n":1,"t":1.0,"sta', 0.0)[0] == []
    watched.connected()
    (frame,), _ = watched.receive(b'{"n":1,"t":3.0,"state":{"depth":2.0}}\n', 3.0)
    assert (frame["t"], watched.state) == (3.0, {"depth": 2.0})


def test_of_a_long_track_a_client_keeps_the_newest() -> None:
    watched = Watched()
    for t in range(0, 3 * KEPT, 50):
        points = [[float(t + n), 60.0, 25.0, 3.0] for n in range(50)]
        watched.take({"n": 1, "t": float(t), "track": points}, 0.0)
        assert len(watched.track) <= KEPT + SPARE
    assert watched.track[-1][0] == 3 * KEPT - 1
    assert len(watched.track) >= KEPT


def test_what_is_told_again_after_a_dropout_is_no_second_event() -> None:
    """A monitor tells its newest events to whoever comes."""
    monitor, watched = Monitor(), Watched()

    def look(now: float, t: float) -> None:
        """By a new connection."""
        watched.connected()
        monitor.connected("a", now)
        monitor.receive("a", wish(most=300), now)
        while line := monitor.frame("a", {"wall": now}, t, now):
            _, answers = watched.receive(line, now)
            monitor.receive("a", answers, now)

    told = [f"{t:8.1f} s  info: now here" for t in (1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 6.0)]
    for line in told[:5]:
        monitor.event(line)
    look(0.0, 4.5)
    assert list(watched.events) == told[:5]
    for line in told[5:]:
        monitor.event(line)
    look(10.0, 6.5)
    look(20.0, 7.0)
    assert (list(watched.events), watched.told) == (told, 7)
    monitor.event(told[-1])
    look(30.0, 7.5)
    assert list(watched.events) == [*told, told[-1]]


def test_a_program_that_began_anew_tells_the_same_first_lines_and_they_are_events() -> None:
    watched = Watched()
    for t in (50.0, 0.5):
        watched.connected()
        watched.take({"n": 1, "t": t, "events": ["     0.0 s  info: now idle/empty"]}, t)
    assert watched.told == 2


# --- on real sockets -----------------------------------------------------------------------------


def place_of(pi: Any) -> tuple[str, int]:
    link = pi.server.viewing.port
    soon(lambda: link.link is not None, "the monitor's port")
    return "127.0.0.1", link.link.port


def observer(place: tuple[str, int], said: bytes = wish()) -> socket.socket:
    viewer = socket.create_connection(place, timeout=PATIENCE)
    viewer.sendall(said)
    return viewer


def test_a_viewer_sees_what_the_pi_is_doing_and_can_say_no_word_of_command(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
    ):
        place = place_of(pi)
        for word in (b"@ZAX0$", b"@ZAWF$\n"):
            with observer(place, word) as viewer:
                soon(lambda v=viewer: v.recv(100) == b"", "its end")  # type: ignore[misc]
        assert pi.has_told("sent away")
        url = f"tcp://127.0.0.1:{place[1]}"
        with pi.boat() as boat:
            boat.sendall(b"@ZAX0$")
            soon(lambda: pi.has_told("now emergency/stopped"), "the stop")
            ran = CliRunner().invoke(monitor_command, [url, "--for", "3"])
        assert ran.exit_code == 0
        watched = Watched()
        for line in ran.stdout.splitlines():
            watched.take(json.loads(line), 0.0)
        assert watched.state["state"] == "emergency/stopped"
        assert any("now emergency/stopped" in event for event in watched.events)
    gone = CliRunner().invoke(monitor_command, [url])
    assert gone.exit_code == 1


def test_a_flood_of_what_is_no_viewer_leaves_some_lines_in_the_journal(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
    ):
        place = place_of(pi)
        for _ in range(OF_A_KIND + 20):
            with observer(place, b"garbage\n") as viewer:
                soon(lambda v=viewer: v.recv(100) == b"", "its end")  # type: ignore[misc]
        assert pi.has_told("warning: monitor: 127.0.0.1:")
        assert pi.tells_within_its_rate("is sent away: it said", OF_A_KIND)
        assert pi.has_told("viewers: beyond")


def test_ten_viewers_who_read_nothing_hold_nobody_up_and_nothing_grows(tmp_path: Path) -> None:
    with simulated(1.0) as sea:
        stm32, _ = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, monitor="tcp://127.0.0.1:0?each=20") as pi:
            place = place_of(pi)
            mute = [observer(place) for _ in range(10)]
            with pi.boat() as boat:
                for _ in range(20):
                    boat.sendall(b"@AE$")
                    assert boat.recv(100).startswith(b"@AE,1,")
            assert pi.server is not None
            port = pi.server.viewing.port.link  # type: ignore[union-attr]
            assert all(len(stream.waiting) == 0 for stream in port.streams.values())  # type: ignore[union-attr]
            for viewer in mute:
                viewer.close()


def test_a_viewers_certificate_opens_the_monitor_and_no_command_port(tmp_path: Path) -> None:
    keys = tmp_path / "keys"
    make_keys(keys, ("boat",), lambda path: None, ("guest",))
    listen = f"tls-listen://127.0.0.1:0?keys={keys / 'vehicle'}"
    for who, viewers, welcome in (("guest", True, True), ("guest", False, False),
                                  ("boat", True, True), ("boat", False, True)):  # fmt: skip
        server = open_link("port", listening_to_viewers(listen) if viewers else listen)
        try:
            assert _reaches(server, f"keys={keys / who}") == welcome
            told = " ".join(refusal.why for refusal in server.refusals())  # type: ignore[attr-defined]
            assert ("viewer's" in told) == (not welcome)
        finally:
            server.close()


def _reaches(server: Any, keys: str) -> bool:
    """Whether bytes of a client with these keys come through."""
    from threading import Thread

    sent: list[str] = []

    def talk() -> None:
        try:
            client = open_link("client", f"tls://127.0.0.1:{server.port}?{keys}")
            client.send(b"hello", 0.0)
            for _ in range(50):
                client.receive(0.0)
                time.sleep(0.02)
            client.close()
        except LinkError as error:
            sent.append(str(error))

    thread = Thread(target=talk)
    thread.start()
    heard = b""
    while thread.is_alive():
        heard += b"".join(rx.data for rx in server.receive(time.monotonic()))
        time.sleep(0.01)
    thread.join()
    return heard == b"hello"


def test_a_handshake_of_a_viewer_may_take_a_minute() -> None:
    url = listening_to_viewers("tls://0.0.0.0:4001?keys=/etc/keys")
    assert url == "tls-listen://0.0.0.0:4001?keys=/etc/keys&handshake=60&viewers=yes"
    assert listening_to_viewers("tcp://127.0.0.1:1?handshake=9").count("handshake") == 1
