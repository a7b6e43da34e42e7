"""Review: a recording under the page's hand, in the same frames as a vehicle."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator

import pytest
from console_world import Console, Page, console
from websockets.sync.client import ClientConnection

from mission.analysis.replay.playback import Playback
from mission.analysis.report.dive import Dive
from mission.analysis.report.words import figures
from mission.authoring.prepare import prepare
from mission.console import film as film_module
from mission.console.board import Board
from mission.console.film import EVERY_S, Film
from mission.console.hindsight import hindsight
from mission.console.recorded import Recorded, told_apart
from mission.console.recording import Recording
from mission.model import Record
from mission.model.past import NAMES
from mission.navigation.geodesy import LocalFrame
from mission.onboard.runtime.records import ListRecorder
from mission.topside.monitor import Watched
from mission.verification.simulation.flight import fly


@pytest.fixture(scope="module")
def records() -> list[Record]:
    prepared, recorder = prepare("float-test"), ListRecorder()
    fly(prepared.mission, prepared.vehicle, recorder=recorder)
    return recorder.records


@pytest.fixture
def review(records: list[Record]) -> Iterator[Console]:
    def made() -> list[Recorded]:
        return [Recorded("1", "dive.mcap", Recording(records), None)]

    with console(made) as running:
        yield running


def says(socket: ClientConnection, **word: object) -> None:
    socket.send(json.dumps(word))


@pytest.mark.proof
def test_a_recording_stands_goes_to_a_time_and_back(review: Console) -> None:
    with review.socket("frames") as frames, review.socket("review") as hand:
        page = Page(frames)
        says(hand, do="pause")
        page.until(lambda s: s.get("review") and not s["review"]["playing"], "standing")
        end = page.state["review"]["end"]
        says(hand, do="seek", t=end)
        page.until(lambda s: s.get("state") == "idle/ready" and page.t == end, "the end")
        assert len(page.track) > 20
        assert any("autonomous/up" in line or "entry of up" in line for line in page.events)
        before = page.snapshots
        says(hand, do="seek", t=1.0)
        page.until(lambda _: page.t == 1.0, "back")
        assert page.snapshots > before
        assert str(page.state["state"]).startswith("idle")
        assert all(point[0] <= 1.0 for point in page.track)


@pytest.mark.proof
def test_it_plays_as_fast_as_it_is_told(review: Console) -> None:
    with review.socket("frames") as frames, review.socket("review") as hand:
        page = Page(frames)
        says(hand, do="play", speed=100)
        page.until(lambda s: s.get("review") and s["review"]["speed"] == 100.0, "the speed")
        page.until(lambda s: s["review"]["end"] <= page.t, "the end")
        page.until(lambda s: not s["review"]["playing"], "it stands at the end")


def test_its_events_are_there_to_jump_to_and_its_plan_is_shown(review: Console) -> None:
    events = review.get("/api/vehicles/1/events")
    assert [e["t"] for e in events] == sorted(e["t"] for e in events)
    assert any(e["says"].startswith("now autonomous/") for e in events)
    with review.socket("frames") as frames, review.socket("review") as hand:
        page = Page(frames)
        says(hand, do="seek", t=events[-1]["t"])
        page.until(lambda s: s.get("plan"), "the plan")
        assert review.get("/api/vehicles/1/plan")["name"] == "float-test"


def test_where_one_jumps_to_an_event_it_is_to_be_seen(records: list[Record]) -> None:
    recording, film = Recording(records), Film(records)
    while not film.over:
        film.extend()
    entered = [e for e in recording.events() if e["says"].startswith("now ")]
    assert entered
    for event in entered:
        shown = film.at(event["t"], 0.0)
        state = event["says"].partition(":")[0]
        assert any(
            state in line and float(line.split()[0]) > event["t"] - EVERY_S for line in shown.events
        ), event


def test_nobody_can_be_told_anything(review: Console) -> None:
    (about,) = review.get("/api/setup")["vehicles"]
    assert (about["source"], about["to"]) == ("recording", "")


@pytest.mark.parametrize("speed", [0.0, 0.5, 101.0, math.nan])
def test_a_speed_that_there_is_not_is_refused(records: list[Record], speed: float) -> None:
    with pytest.raises(ValueError, match="from 1 to 100"):
        Recording(records).play(speed)


def test_what_is_no_recording_is_refused() -> None:
    with pytest.raises(ValueError, match="no whole start record"):
        Recording([])


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (["log/a.mcap", "log/b.mcap"], ["a.mcap", "b.mcap"]),
        (["/sea/1/flight.mcap", "/sea/2/flight.mcap"], ["1/flight.mcap", "2/flight.mcap"]),
        (["a/x/flight.mcap", "b/x/flight.mcap", "c.mcap"],
         ["a/x/flight.mcap", "b/x/flight.mcap", "c.mcap"]),
        (["flight.mcap", "old/flight.mcap"], ["flight.mcap", "old/flight.mcap"]),
        (["a/f.mcap", "a/f.mcap"], ["f.mcap", "f.mcap (2)"]),
        (["float-test"], ["float-test"]),
    ],
)  # fmt: skip
def test_recordings_of_one_name_are_told_apart_by_no_more_than_it_takes(
    files: list[str], names: list[str]
) -> None:
    assert told_apart(files) == names


# --- the film ---------------------------------------------------------------------------------


def whole(records: list[Record]) -> Film:
    film = Film(records)
    while not film.over:
        film.extend()
    return film


@pytest.mark.proof
def test_what_stood_at_a_time_is_the_same_by_the_film_as_by_running_up_to_it(
    records: list[Record], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film_module, "KEY", 7)
    film = whole(records)
    for t in (0.0, 3.0, 20.5, 41.0, film.end):
        ran, playback = Watched(), Playback(records)
        for to in (*(n * EVERY_S for n in range(int(t / EVERY_S) + 1)), t):
            _, answers = ran.receive(playback.until(to), 0.0)
            playback.answer(answers)
        found = film.at(t, 0.0)
        assert (found.state, list(found.events)) == (ran.state, list(ran.events))
        assert (found.track, found.plan, found.told) == (ran.track, ran.plan, ran.told)
        assert found.past.rows == ran.past.rows


@pytest.mark.proof
def test_playing_on_from_a_time_ends_where_a_jump_would(records: list[Record]) -> None:
    film = whole(records)
    watched = film.at(10.0, 0.0)
    for frame in film.between(10.0, 30.0):
        watched.take(frame, 0.0)
    there = film.at(30.0, 0.0)
    assert (watched.state, watched.track, watched.told) == (there.state, there.track, there.told)
    assert watched.past.rows == there.past.rows
    assert len(there.past.rows) > 10


def pasts(board: Board, page: str, watched: Watched, t: float) -> list[float]:
    """Times of the rows that a page is told of, until nothing is left."""
    told = list[float]()
    while line := board.frame(page, watched, {**watched.state, "wall": len(told)}, t, t):
        frame = json.loads(line)
        board.answer(page, frame["n"], t)
        if not frame.get("past"):
            return told
        told += [row[0] for row in frame["past"]]
    return told


def test_a_page_that_comes_late_has_all_rows_of_before_and_then_each_once() -> None:
    board, watched = Board(), Watched()

    def passes(t: float) -> None:
        watched.take({"t": t, "state": {"report_at": t, "battery": 12.0}}, t)

    for t in range(100):
        passes(float(t))
    board.come("late", 100.0)
    assert pasts(board, "late", watched, 100.0) == list(range(100))
    passes(100.0)
    watched.take({"t": 100.5, "past": [[-5.0, *(1.0 for _ in NAMES)]]}, 100.5)  # learned behind it
    assert pasts(board, "late", watched, 101.0) == [100.0, -5.0]
    board.come("later", 101.0)
    assert sorted(pasts(board, "later", watched, 101.0)) == [-5.0, *range(101)]


@pytest.mark.proof
def test_a_jump_fills_the_strips_with_what_went_before_and_with_nothing_behind(
    records: list[Record],
) -> None:
    film, board = whole(records), Board()
    board.come("page", 0.0)
    for t in (film.end, 30.0):
        told = pasts(board, "page", film.at(t, 0.0), t)
        assert told[0] < 2.0
        assert t - 4.0 <= told[-1] <= t


@pytest.mark.proof
def test_a_jump_runs_nothing_again(records: list[Record], monkeypatch: pytest.MonkeyPatch) -> None:
    """However long the recording is: the film has been run once."""
    ran = list[float]()
    until = Playback.until
    monkeypatch.setattr(Playback, "until", lambda self, t: [ran.append(t), until(self, t)][1])
    film = whole(records)
    before = len(ran)
    for t in (film.end, 1.0, 30.0, 0.0):
        film.at(t, 0.0)
    assert before == len(ran) == len(set(ran))


def test_a_recording_that_cannot_be_run_stands_and_says_why(
    records: list[Record], monkeypatch: pytest.MonkeyPatch
) -> None:
    until = Playback.until

    def broken(self: Playback, t: float) -> bytes:
        if t > 5.0:
            raise KeyError("leg")
        return until(self, t)

    monkeypatch.setattr(Playback, "until", broken)
    recorded = Recorded("1", "dive.mcap", Recording(records), None)
    with console(lambda: [recorded]) as running, running.socket("frames") as frames:
        page = Page(frames)
        page.until(lambda s: s.get("problem"), "the problem")
        assert page.state["problem"] == "it cannot be run beyond 5.0 s: KeyError('leg')"
        page.until(lambda s: not s["review"]["playing"] and page.t == 5.0, "it stands")
        with running.socket("review") as hand:
            says(hand, do="seek", t=40.0)
            says(hand, do="seek", t=2.0)
            page.until(lambda _: page.t == 2.0, "the part that there is")


def test_a_thread_that_fails_plays_no_more(
    records: list[Record], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = Recording(records)
    monkeypatch.setattr(Film, "at", lambda *asked: 1 / 0)
    recording.run()
    assert not recording.playing
    assert "division by zero" in recording.problem


# --- afterwards -----------------------------------------------------------------------------------


@pytest.mark.proof
def test_afterwards_the_track_is_known_as_it_was_estimated_and_smoothed(
    review: Console, records: list[Record]
) -> None:
    found = review.get("/api/vehicles/1/hindsight")
    dive = Dive.of(records, None)
    assert dive.smoothed is not None
    assert found["begin"] == dive.stays()[0].begin
    assert [point[0] for point in found["then"]] == [round(t, 1) for t, _, _ in dive.places]
    assert len(found["now"]) == len(dive.smoothed.t)
    known = figures(dive)
    assert known is not None
    assert found["apart"]["max"] == known["filtered_from_smoothed_m"]["max"]
    assert dive.origin is not None
    plane = LocalFrame(dive.origin)
    _, lat, lon = found["now"][-1]
    back = plane.to_local(math.radians(lat), math.radians(lon))
    assert back == pytest.approx(tuple(dive.smoothed.smoothed[-1]), abs=0.05)


def test_without_a_fix_there_is_no_smoothed_track_and_it_says_so(records: list[Record]) -> None:
    dry = [record for record in records if b"$G" not in record.payload]
    found = hindsight(dry)
    assert (found["now"], "no fix" in found["problem"]) == ([], True)


# --- the board ------------------------------------------------------------------------------------


def frame(board: Board, watched: Watched, t: float) -> dict[str, object]:
    said = board.frame("a", watched, {**watched.state, "wall": t}, t, t)
    return dict(json.loads(said)) if said else {}


def test_a_vehicle_that_begins_anew_is_a_new_snapshot_for_every_page() -> None:
    board, watched = Board(), Watched()
    board.come("a", 0.0)
    watched.take({"n": 1, "t": 100.0, "state": {"depth": 3.0}, "track": [[99.0, 1, 2, 3]]}, 0.0)
    assert frame(board, watched, 100.0)["n"] == 1
    board.answer("a", 1, 100.0)
    watched.take({"n": 1, "t": 0.5, "state": {"depth": 0.1}, "track": [[0.4, 1, 2, 0]]}, 0.5)
    again = frame(board, watched, 101.0)
    assert (again["n"], again["track"]) == (1, [[0.4, 1, 2, 0]])


def test_an_answer_to_what_was_before_is_no_answer() -> None:
    board, watched = Board(), Watched()
    board.come("a", 0.0)
    watched.take({"n": 1, "t": 1.0, "state": {"depth": 3.0}}, 0.0)
    frame(board, watched, 1.0)
    board.answer("a", 7, 1.0)
    assert not board.is_due("a", 5.0)
    board.answer("a", 1, 1.0)
    assert board.is_due("a", 5.0)


def test_a_track_that_is_told_again_is_shown_once() -> None:
    """As a monitor does when the link was lost and is back."""
    board, watched = Board(), Watched()
    board.come("a", 0.0)
    track = [[float(t), 1, 2, 3] for t in range(5)]
    watched.take({"n": 1, "t": 5.0, "track": track}, 0.0)
    first = frame(board, watched, 5.0)
    watched.take({"n": 1, "t": 6.0, "track": [*track, [5.0, 1, 2, 3]]}, 1.0)
    board.answer("a", 1, 5.0)
    second = frame(board, watched, 6.0)
    assert (first["track"], second["track"]) == (track, [[5.0, 1, 2, 3]])
