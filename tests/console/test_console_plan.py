"""The plan of the console on its wire: places of a text, edits, imports, differences, ghosts."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import gc
import http.client
import itertools
import json
import math
import sys
import tempfile
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from console_world import Console, console
from served import PATIENCE
from websockets.exceptions import ConnectionClosed

from mission.authoring.prepare import prepare
from mission.console import plans
from mission.console.asked import Refused, worked
from mission.console.ghost import KEPT, Ghosts
from mission.console.planning import difference
from mission.console.vehicle import Given, Vehicle
from mission.model.shipped import shipped_missions, vehicle_file

HOME = [30.2874595, 120.1535765]
TRANSECT = prepare("transect").text
DIP = """mission dip
home 30.2874595 120.1535765
safety time 10min depth 10
dive: depth 3 heading 0 gear 4 until depth > 2.5 timeout 60s
up: surface until fix timeout 3min
"""
GPX = b"""<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">
<rte><name>bay</name><rtept lat="30.288" lon="120.154"><ele>0</ele></rtept>
<rtept lat="30.289" lon="120.154"/></rte></gpx>"""


def offset_of(text: str, line: int, column: int) -> int:
    return sum(len(row) + 1 for row in text.split("\n")[: line - 1]) + column - 1


def test_every_shipped_mission_is_answered_with_its_places_and_where_their_numbers_stand() -> None:
    for name, path in shipped_missions().items():
        text = path.read_text(encoding="utf-8")
        found = plans.checked(text, path.name, None)
        assert found["ok"], name
        assert [p["kind"] for p in found["places"]].count("home") <= 1
        for place in found["places"]:
            for line, column, length in place["spans"]:
                begin = offset_of(text, line, column)
                float(text[begin : begin + length].split()[0])


def test_the_graph_is_drawn_of_what_is_on_board_and_of_no_text_under_work() -> None:
    text = shipped_missions()["transect"].read_text(encoding="utf-8")
    assert plans.checked(text, "transect.yaml", None)["svg"] == ""
    assert "<svg" in plans.on_board(TRANSECT.split("\n"), None)["svg"]


def test_a_text_with_errors_keeps_its_places_and_its_home() -> None:
    found = plans.checked(TRANSECT.replace("surface: true", "surfaec: true"), "t.yaml", None)
    assert not found["ok"]
    assert found["home"] == HOME
    assert len(found["places"]) == 4
    assert found["refusals"][0]["line"] > 0


def long(legs: int) -> str:
    rows = (f"  - leg_{n}: {{heading: {n % 360}, gear: 6, for: 5 s}}\n" for n in range(legs))
    return (
        "mission: long\nvehicle: auv\nhome: {latitude: 30.2874595, longitude: 120.1535765}\n"
        "safety: {radius: 1400 m, time: 300 min, depth: 30 m}\nlegs:\n"
        f"{''.join(rows)}  - up: {{surface: true, timeout: 5 min}}\n"
    )


def calls_of(text: str) -> int:
    """Calls of functions that an answer takes."""
    called, before = itertools.count(), sys.getprofile()

    def seen(frame: object, event: str, argument: object) -> None:
        if event == "call":
            next(called)

    sys.setprofile(seen)
    try:
        plans.checked(text, "long.yaml", None)
    finally:
        sys.setprofile(before)
    return next(called)


def test_an_answer_while_typing_costs_as_much_for_each_line_however_many_there_are() -> None:
    plans.checked(long(1), "long.yaml", None)
    few, some, many = (calls_of(long(legs)) for legs in (20, 60, 100))
    assert many - some < 1.05 * (some - few)
    assert some - few < 40 * 1000, "calls for a line"


def test_typing_reads_the_vehicles_file_once_and_again_where_it_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = list[str]()
    reading = plans.read_vehicle
    monkeypatch.setattr(
        plans, "read_vehicle", lambda text, where: [read.append(text), reading(text, where)][1]
    )
    file = tmp_path / "mine.yaml"
    file.write_text(vehicle_file("auv").read_text(encoding="utf-8"))
    for legs in (1, 2, 3):
        assert plans.checked(long(legs), "long.yaml", str(file))["ok"]
    assert len(read) == 1
    file.write_text(file.read_text().replace("vehicle: auv", "vehicle: auv  # mended", 1))
    assert plans.checked(long(1), "long.yaml", str(file))["ok"]
    assert len(read) == 2


def test_the_names_that_an_exit_may_lead_to_are_told() -> None:
    assert {"first", "dive", "run", "fix", "up"} <= set(plans.checked(TRANSECT, "", None)["names"])


def test_an_edit_is_made_by_the_server_and_read_again() -> None:
    with console(list) as running:
        to = [HOME[0] + 0.002, HOME[1]]
        said = {"text": TRANSECT, "source": "t.yaml"}
        moved = running.get("/api/edit", {**said, "do": "move", "at": 1, "to": to})["text"]
        rows = zip(TRANSECT.split("\n"), moved.split("\n"), strict=True)
        assert sum(a != b for a, b in rows) == 1
        grown = running.get("/api/edit", {**said, "do": "add", "what": "goto", "to": to})["text"]
        places = running.get("/api/check", {"text": grown, "source": "t.yaml"})["places"]
        fresh = next(i for i, place in enumerate(places) if place["path"] == "goto_1")
        assert math.dist(places[fresh]["at"], to) < 1e-6
        less = {"text": grown, "source": "t.yaml", "do": "remove", "at": fresh}
        assert running.get("/api/edit", less)["text"] == TRANSECT


@pytest.mark.parametrize(
    ("path", "body", "status", "says"),
    [
        ("/api/edit", {"text": TRANSECT, "source": "t.yaml", "do": "remove", "at": 0}, 200, "home"),
        ("/api/edit", {"text": TRANSECT, "source": "t.yaml", "do": "paint"}, 200, "an edit is"),
        ("/api/edit", {"text": TRANSECT, "source": "t.yaml", "do": "move"}, 400, "needs"),
        ("/api/edit", {"text": TRANSECT, "source": "", "do": "move", "at": "0", "to": HOME}, 400,
         "needs"),
        ("/api/edit", {"text": TRANSECT, "source": "", "do": "move", "at": 0, "to": [1]}, 400,
         "needs"),
        ("/api/edit", {"text": "x" * (1 << 20), "source": "", "do": "move", "at": 0, "to": HOME},
         413, "bytes"),
        ("/api/edit", [], 400, "needs"),
        ("/api/import", {"name": "a.gpx", "data": "?"}, 400, "needs"),
        ("/api/import", {"name": "a.doc", "data": ""}, 200, "suffix"),
        ("/api/import", {"name": "a.gpx", "data": base64.b64encode(GPX).decode()}, 200, "home"),
        ("/api/vehicles/1/diff", {"text": TRANSECT, "source": "t.yaml"}, 200, "on board"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_answered_with_the_reason(
    path: str, body: Any, status: int, says: str
) -> None:
    with console(list) as running:
        found, _, answer = running.ask(path, body)
        assert found == status
        assert says in json.loads(answer)["says"]


def test_nothing_of_the_plan_is_told_without_the_token() -> None:
    with console(list) as running:
        for path in ("/api/words", "/api/edit", "/api/import", "/api/vehicles/1/diff"):
            body = None if path == "/api/words" else {}
            assert running.ask(path, body, Authorization="")[0] == 403


def test_the_words_of_the_language_come_with_what_they_say() -> None:
    with console(list) as running:
        words = running.get("/api/words")
    of = {(row["of"], row["word"]) for row in words}
    assert {("leg", "goto"), ("mission", "home"), ("guard", "battery"), ("safety", "radius")} <= of
    assert all(row["says"] for row in words)


def test_a_plan_of_another_program_is_imported_with_what_was_left_out() -> None:
    said = {"name": "../bay.gpx", "data": base64.b64encode(GPX).decode(), "home": "first",
            "depth": 3.0, "gear": 6}  # fmt: skip
    with console(list) as running:
        found = running.get("/api/import", said)
        assert found["source"] == "bay.yaml"
        assert "p2" in found["text"]
        assert plans.checked(found["text"], found["source"], None)["places"]


def test_a_difference_is_what_changes_for_the_vehicle_and_line_by_line() -> None:
    after = TRANSECT.replace("north: 600 m", "north: 500 m")
    found = difference(after, "t.yaml", TRANSECT, None)
    assert not found["same"]
    marked = [row for row in found["rows"] if row[0] != " "]
    assert [row[0] for row in marked] == ["-", "+"]
    commented = difference("# a note\n" + TRANSECT, "t.yaml", TRANSECT, None)
    assert commented["same"]
    assert {row[0] for row in commented["rows"]} == {" "}
    with pytest.raises(Refused, match="mend the text"):
        difference("legs: [", "t.yaml", TRANSECT, None)


@pytest.mark.proof
def test_missions_that_differ_in_each_line_are_compared_in_a_while() -> None:
    def turned(by: int) -> str:
        rows = (
            f"l{i}: depth 3 heading {(7 * i + by) % 360} gear 4 for {10 + by}s" for i in range(400)
        )
        return "\n".join(["mission big", *rows, "up: surface until fix timeout 3min"])

    began = time.process_time()
    found = difference(turned(5), "b.mission", turned(0), None)
    taken = time.process_time() - began
    began = time.process_time()
    plans.checked(turned(0), "b.mission", None)
    assert taken < 4.0 * (time.process_time() - began)
    marks = [row[0] for row in found["rows"]]
    assert marks.count("-") == marks.count("+") >= 400


def test_texts_that_are_worked_on_leave_the_vehicles_threads_alone() -> None:
    async def asked() -> bool:
        hold = threading.Event()
        texts = [asyncio.ensure_future(worked(hold.wait, PATIENCE)) for _ in range(40)]
        try:
            await asyncio.wait_for(asyncio.to_thread(str), 5.0)
        finally:
            hold.set()
            await asyncio.gather(*texts)
        return True

    assert asyncio.run(asked())


# --- ghosts ---------------------------------------------------------------------------------------

FLY = {"do": "fly", "text": DIP, "source": "dip.mission", "settings": ["current=0.1@90"], "seed": 4}


def told(socket: Any, *wanted: str) -> dict[str, Any]:
    end = time.monotonic() + PATIENCE
    while (answer := json.loads(socket.recv(PATIENCE)))["is"] not in wanted:
        assert time.monotonic() < end
    return dict(answer)


@pytest.mark.proof
def test_a_ghost_flies_in_the_sea_that_was_chosen_and_says_which() -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps(FLY))
        assert told(socket, "flying", "refused")["is"] == "flying"
        done = told(socket, "done", "refused")
        assert (done["outcome"], done["seed"]) == ("completed", 4)
        assert done["settings"] == ["current=0.1@90"]
        assert len(done["up"]) == 1
        t, latitude, longitude, ellipse = done["believed"][-1]
        assert t > 0.0
        assert math.dist([latitude, longitude], HOME) < 0.01
        assert ellipse[0] >= ellipse[1] > 0.0
        assert len(done["track"]) == len(done["believed"])


@pytest.mark.proof
def test_a_ghost_that_cannot_fly_says_why() -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps({**FLY, "settings": ["moon=1"]}))
        assert "moon" in told(socket, "done", "refused")["says"]


@pytest.mark.parametrize("said", [{"do": "swim"}, {"do": "fly"}, {**FLY, "text": "x" * 2_000_000}])
def test_a_page_that_asks_a_ghost_for_what_is_none_is_closed(said: dict[str, Any]) -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps(said))
        with pytest.raises(ConnectionClosed) as closed:
            told(socket, "done")
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code in (1008, 1009)


def test_a_ghost_is_cancelled_and_its_process_ends() -> None:
    async def flown() -> tuple[list[str], int]:
        ghosts, said = Ghosts(), list[str]()

        async def tell(answer: dict[str, Any]) -> None:
            said.append(answer["is"])

        flight = asyncio.ensure_future(ghosts.fly(FLY, None, tell))
        while not said:
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.1)  # its pipes are open
        flight.cancel()
        await asyncio.gather(flight, return_exceptions=True)
        return said, ghosts.under_way

    with warnings.catch_warnings(record=True) as left:
        warnings.simplefilter("always")
        assert asyncio.run(flown()) == (["flying"], 0)
        gc.collect()
    assert [str(one.message) for one in left] == []


def test_a_ghost_that_takes_too_long_is_ended_and_no_more_than_two_fly_at_once() -> None:
    async def flown() -> list[dict[str, Any]]:
        ghosts, said = Ghosts(longest=0.05), list[dict[str, Any]]()

        async def tell(answer: dict[str, Any]) -> None:
            said.append(answer)

        await asyncio.gather(*(ghosts.fly(FLY, None, tell) for _ in range(3)))
        return said

    says = sorted(answer.get("says", "") for answer in asyncio.run(flown()))
    assert says == ["", "", "2 flights are under way already", *["it takes longer than 0.05 s"] * 2]


def test_the_console_goes_on_while_a_ghost_flies() -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps(FLY))
        told(socket, "flying")
        for _ in range(3):
            assert setup(running)["vehicles"] == []
        socket.send(json.dumps({"do": "cancel"}))
        assert told(socket, "cancelled", "done")["is"] == "cancelled"


# --- in still water -------------------------------------------------------------------------------

STEERED = {"do": "plan", "text": DIP, "source": "dip.mission"}


@pytest.mark.proof
def test_legs_by_heading_have_a_track_in_still_water_and_are_less_sure_as_they_go() -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps(STEERED))
        found = told(socket, "planned", "refused")
    assert found["is"] == "planned", found
    times = [row[0] for row in found["track"]]
    assert times == sorted(times)
    assert all(math.dist(row[1:], HOME) < 0.01 for row in found["track"])
    assert found["track"][-1][0] <= found["seconds"] + 1.0
    assert [name for *_, name in found["turns"]] == ["dive", "up"]
    (_, _, _, (great, small, bearing), _), *_ = found["turns"]
    assert great >= small > 0.0
    assert 0.0 <= bearing < 180.0


@pytest.mark.proof
@pytest.mark.parametrize(
    ("text", "says"),
    [
        (DIP.replace("home 30.2874595 120.1535765", "start fix"), ""),
        ("legs: [", ""),
        (DIP.replace("depth 10\n", "depth 2\n"), "still water"),
    ],
)
def test_what_has_no_track_in_still_water_says_why(text: str, says: str) -> None:
    with console(list) as running, running.socket("ghost") as socket:
        socket.send(json.dumps({**STEERED, "text": text}))
        found = told(socket, "planned", "refused")
    assert found["is"] == "refused"
    assert says in found["says"]


class Counted(Ghosts):
    """Flies nothing, and counts."""

    def __init__(self) -> None:
        super().__init__()
        self.jobs, self.flying, self.most = 0, 0, 0

    async def _flown(self, job: bytes, longest: float) -> dict[str, Any]:
        self.jobs, self.flying = self.jobs + 1, self.flying + 1
        self.most = max(self.most, self.flying)
        try:
            await asyncio.sleep(0.01)
        finally:
            self.flying -= 1
        return {"is": "planned"}


def test_tracks_in_still_water_wait_for_each_other_take_no_ghosts_place_and_are_kept() -> None:
    async def asked() -> Counted:
        ghosts = Counted()

        def want(text: str) -> asyncio.Future[dict[str, Any]]:
            return asyncio.ensure_future(ghosts.planned({**STEERED, "text": text}, None))

        texts = [f"text {number}" for number in range(KEPT + 2)]
        await asyncio.gather(*map(want, texts))
        assert ghosts.under_way == 0
        await want(texts[-1])
        assert ghosts.jobs == KEPT + 2
        await want(texts[0])
        assert ghosts.jobs == KEPT + 3
        flies, waits = want("newer"), want("newest")
        await asyncio.sleep(0)
        for one in (waits, flies):
            one.cancel()
        await asyncio.gather(flies, waits, return_exceptions=True)
        await asyncio.wait_for(want("another"), PATIENCE)
        return ghosts

    ghosts = asyncio.run(asked())
    assert (ghosts.most, ghosts.flying) == (1, 0)


def test_a_console_that_ends_while_a_track_is_flown_leaves_no_process(
    capfd: pytest.CaptureFixture[str],
) -> None:
    class Plans(Vehicle):
        def plan(self) -> dict[str, Any]:
            return {"digest": "d", "text": TRANSECT}

    with (
        warnings.catch_warnings(record=True) as left,
        tempfile.TemporaryDirectory() as memory,
        ThreadPoolExecutor(1) as asking,
        console(lambda: [Plans("1", Given("auv-1", "tcp://127.0.0.1:9"), Path(memory))]) as running,
    ):
        warnings.simplefilter("always")
        lost = asking.submit(running.ask, "/api/vehicles/1/planned")
        time.sleep(0.3)
        running.stop()
        with contextlib.suppress(http.client.HTTPException, OSError):
            lost.result()
        gc.collect()
    assert [str(one.message) for one in left if "subprocess" in str(one.message)] == []
    assert "Traceback" not in capfd.readouterr().err


def test_the_track_of_what_is_on_board_is_of_that_vehicle_and_needs_the_token() -> None:
    with console(list) as running:
        path = "/api/vehicles/1/planned"
        assert running.ask(path)[0] == 404
        assert running.ask(path, Authorization="")[0] == 403


def setup(running: Console) -> dict[str, Any]:
    return dict(running.get("/api/setup"))
