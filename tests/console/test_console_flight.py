"""The wire of the console against the real serve: intents, X and W, the stick, what is shown."""

from __future__ import annotations

import json
import threading
import time
from collections import deque
from pathlib import Path
from typing import Any

import pytest
from cable import cable
from console_world import Console, Page, at_sea, cockpit, console_of, heard, monitor_of, said
from ports import free_port
from served import LINES, MISSION, PATIENCE, TEXT, Running, quiet, running, silent_board, soon
from served import simulated as simulated_board
from websockets.exceptions import ConnectionClosed

from mission.authoring.language import digest, script
from mission.console.plans import of_vehicle
from mission.topside.console import converse
from mission.topside.upload import start, upload

DIGEST = digest(MISSION)[:16]
HOUR = 3600.0


def plan_of(console: Console) -> dict[str, Any]:
    return dict(console.get("/api/vehicles/1/plan"))


def is_ours(state: dict[str, object]) -> bool:
    return isinstance(known := state.get("command"), dict) and known["is"] in ("us", "nobody")


# --- what is shown --------------------------------------------------------------------------------


def test_a_page_is_told_all_and_then_what_changes(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (_, console, _), console.socket("frames") as socket:
        page = Page(socket)
        first = page.take()
        assert first["n"] == 1
        page.until(lambda s: s.get("state") == "idle/empty", "the state")
        page.until(lambda s: s["silence"] is not None and s["silence"] < 5, "its age")
        page.until(is_ours, "who commands")
        page.until(lambda s: s["lines"]["orders"] is not None, "the line of orders")
        later = page.take()
        assert later["n"] > 1
        assert set(later["state"]) < set(page.state)
        assert page.snapshots == 1


def test_one_frame_is_unanswered_and_the_next_is_of_now(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (_, console, _), console.socket("frames") as socket:
        first = json.loads(socket.recv(PATIENCE))
        with pytest.raises(TimeoutError):
            socket.recv(3.0)
        asked = time.time()
        socket.send(json.dumps({"ack": first["n"]}))
        second = json.loads(socket.recv(PATIENCE))
        assert second["n"] == first["n"] + 1
        assert second["state"]["wall"] >= int(asked)
        assert second["t"] >= first["t"] + 3.0


def test_two_pages_are_told_each_by_its_own_answers(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (_, console, _), console.socket("frames") as slow:
        slow.recv(PATIENCE)
        with console.socket("frames") as socket:
            page = Page(socket)
            page.until(lambda s: s.get("state") == "idle/empty", "the state")
            beats = {page.take()["state"].get("wall") for _ in range(12)}
            assert len(beats) > 1


def test_what_is_on_board_comes_with_its_picture_and_its_map(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("frames") as socket:
        page = Page(socket)
        page.until(lambda s: s.get("mission") == "", "nothing on board")
        soon(lambda: plan_of(console)["problem"] == "no mission is on board", "no plan")
        converse(pi.url, upload(LINES, digest(MISSION), quiet))
        page.until(lambda s: s.get("plan") == DIGEST, "the plan")
        plan = plan_of(console)
        assert (plan["digest"], plan["name"], plan["lines"]) == (DIGEST, "pool", len(LINES))
        assert 'data-path="out"' in plan["svg"]
        assert plan["home"] == [30.2874595, 120.1535765]
        names = {f["properties"]["name"] for f in plan["map"]["features"]}
        assert {"home", "radius"} <= names


def test_without_a_monitor_the_command_port_is_asked(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}") as pi,
        console_of(pi.url, tmp_path, "tcp://127.0.0.1:1") as (console, _),
        console.socket("frames") as socket,
    ):
        page = Page(socket)
        page.until(lambda s: s.get("state") == "idle/empty", "the state by @AE")
        (about,) = console.get("/api/setup")["vehicles"]
        assert about["source"] == "frames"


def test_a_vehicle_that_is_gone_is_silent_and_an_alarm_says_so(tmp_path: Path) -> None:
    with silent_board() as (_, board):
        pi = Running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0")
        try:
            with (
                console_of(pi.url, tmp_path, monitor_of(pi)) as (console, _),
                console.socket("frames") as socket,
            ):
                page = Page(socket)
                page.until(lambda s: s.get("state") == "idle/empty", "the state")
                pi.stop()
                page.until(lambda s: (s["silence"] or 0) > 5, "silence")
                page.until(
                    lambda s: any(a["name"] == "no contact" for a in s["alarms"]), "the alarm"
                )
                assert page.state["problem"]
                assert page.state["lines"]["orders"] is None
        finally:
            pi.stop()


def test_the_plan_stays_known_while_the_vehicle_is_gone(tmp_path: Path) -> None:
    with silent_board() as (_, board):
        pi = Running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0")
        try:
            converse(pi.url, upload(LINES, digest(MISSION), quiet))
            with (
                console_of(pi.url, tmp_path, monitor_of(pi)) as (console, _),
                console.socket("frames") as socket,
            ):
                page = Page(socket)
                page.until(lambda s: s.get("plan") == DIGEST, "the plan")
                pi.stop()
                page.until(lambda s: (s["silence"] or 0) > 5, "silence")
                assert (page.state["plan"], plan_of(console)["digest"]) == (DIGEST, DIGEST)
        finally:
            pi.stop()


# --- intents --------------------------------------------------------------------------------------


def test_an_intent_is_answered_by_what_became_of_it(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        with console.socket("commands") as commands:
            said(commands, do="upload", text=TEXT, source="pool.mission")
            progress = heard(commands, "progress", "refused")
            assert progress["of"] == len(LINES)
            done = heard(commands, "acknowledged", "refused", "unanswered")
            assert (done["is"], DIGEST in done["says"]) == ("acknowledged", True)
            assert tuple(pi.store.content.lines) == tuple(LINES)
            page.until(lambda s: s["command"]["is"] == "us", "the command")
            said(commands, do="start", digest="0" * 16)
            no = heard(commands, "acknowledged", "refused")
            assert no["says"] == f"on board is {DIGEST}, and not {'0' * 16}"
            said(commands, do="start", digest=DIGEST)
            no = heard(commands, "acknowledged", "refused")
            assert (no["is"], no["says"][:3]) == ("refused", "AA:")  # the vehicle's own reason
            said(commands, do="clear")
            assert heard(commands, "acknowledged", "refused")["is"] == "acknowledged"
            page.until(lambda s: s["mission"] == "", "nothing on board")
        log = [json.loads(line) for line in (tmp_path / "console.jsonl").read_text().splitlines()]
        assert [(note["do"], note["became"]) for note in log] == [
            ("upload", "acknowledged"),
            ("start", "refused"),
            ("start", "refused"),
            ("clear", "acknowledged"),
        ]


def test_what_is_done_over_a_long_way_is_not_told_to_be_unanswered(tmp_path: Path) -> None:
    """Three tries of a second each end before the first answer can be there."""
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
        cable(pi.url, delay=1.8) as way,
        console_of(way.url, tmp_path, monitor_of(pi)) as (console, _),
        console.socket("frames") as frames,
    ):
        converse(pi.url, upload(LINES, digest(MISSION), quiet))
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("commands") as commands:
            said(commands, do="clear")
            done = heard(commands, "acknowledged", "refused", "unanswered")
        assert (done["is"], done["says"]) == ("acknowledged", "cleared")
        assert tuple(pi.store.content.lines) == ()


def test_what_is_older_than_half_a_second_is_refused_and_never_said(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("frames") as frames:
        converse(pi.url, upload(LINES, digest(MISSION), quiet))
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("commands") as commands:
            said(commands, do="clear", at=time.time() - 0.6)
            no = heard(commands, "acknowledged", "refused")
            assert (no["is"], "press again" in no["says"]) == ("refused", True)
            said(commands, do="clear", at=time.time() + HOUR)
            assert "clock" in heard(commands, "acknowledged", "refused")["says"]
        assert tuple(pi.store.content.lines) == tuple(LINES)


def test_a_mission_that_the_check_refuses_is_not_sent(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("commands") as commands:
        bad = TEXT.replace("depth 3 heading", "depth 30 heading")
        said(commands, do="upload", text=bad, source="pool.mission")
        no = heard(commands, "acknowledged", "refused", "sent")
        assert (no["is"], "the check refuses it" in no["says"]) == ("refused", True)
        said(commands, do="upload", text="nonsense: [", source="x.yaml")
        assert heard(commands, "acknowledged", "refused", "sent")["is"] == "refused"
        assert not pi.store.content.lines


def test_any_word_of_the_boat_is_said(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("frames") as frames:
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("commands") as commands:
            said(commands, do="say", word="SP", values={"depth_m": 7.0})
            assert heard(commands, "acknowledged", "refused")["is"] == "acknowledged"
            assert pi.store.content.limits.depth == 7.0
            said(commands, do="say", word="SP", values={"deepth": 7.0})
            no = heard(commands, "acknowledged", "refused")
            assert "deepth" in no["says"]
            said(commands, do="say", word="XY", values={})
            assert "no word" in heard(commands, "acknowledged", "refused")["says"]


def test_a_point_of_the_checklist_is_ticked_for_every_page_and_on_record(tmp_path: Path) -> None:
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}") as pi,
        console_of(pi.url, tmp_path, checklist=("hatches closed",)) as (console, _),
        console.socket("frames") as frames,
        console.socket("commands") as commands,
    ):
        page = Page(frames)
        said(commands, do="check", point="hatches closed", done=True)
        assert heard(commands, "acknowledged")["says"] == "hatches closed"
        page.until(lambda s: "hatches closed" in (s.get("checked") or {}), "the point")
        said(commands, do="check", point="other", done=True)
        assert "no point" in heard(commands, "refused")["says"]
    assert "hatches closed" in (tmp_path / "console.jsonl").read_text()


def test_what_doctor_finds_in_the_vehicles_file_stands_in_the_checklist(tmp_path: Path) -> None:
    nobody = "tcp://127.0.0.1:1"
    with console_of(nobody, tmp_path, vehicle="auv") as (console, _):
        found = console.get("/api/vehicles/1/doctor")
        assert found == of_vehicle("auv")
        assert {one["what"] for one in found} >= {"buoyancy", "assumed"}
        assert all(one["todo"] for one in found if one["condition"] != "ok")
    with console_of(nobody, tmp_path) as (console, _):
        assert console.get("/api/vehicles/1/doctor") == []  # which it is, the plan on board says
    assert of_vehicle("no-such") == []


# --- who commands ---------------------------------------------------------------------------------


def test_the_command_is_taken_kept_and_left(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, _), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        with pi.boat() as other, console.socket("commands") as commands:
            other.sendall(b"@AC$")
            page.until(lambda s: s["command"]["is"] == "other", "another")
            said(commands, do="take")
            no = heard(commands, "acknowledged", "refused")
            assert (no["is"], "commands; others read" in no["says"]) == ("refused", True)
            other.close()
            page.until(lambda s: s["command"]["is"] == "nobody", "nobody")
            said(commands, do="take")
            assert heard(commands, "acknowledged", "refused")["is"] == "acknowledged"
            page.until(lambda s: s["command"]["is"] == "us", "us")
            said(commands, do="leave")
            page.until(lambda s: s["command"]["is"] == "nobody", "left")


@pytest.mark.proof
def test_the_command_is_not_left_in_the_middle_of_an_upload(tmp_path: Path) -> None:
    rows = "".join(f"a{n}: heading 90 gear 4 for 2s\n" for n in range(60))
    with cockpit(tmp_path) as (_, console, _), console.socket("frames") as frames:
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("commands") as commands:
            said(
                commands,
                do="upload",
                text=TEXT.replace("up: ", f"{rows}up: "),
                source="long.mission",
            )
            assert heard(commands, "progress", "refused", "acknowledged")["is"] == "progress"
            said(commands, do="leave", id=2)
            while (no := heard(commands, "acknowledged", "refused"))["id"] != 2:
                pass
            assert (no["is"], "under way" in no["says"]) == ("refused", True)


def test_the_command_is_free_once_no_page_looks(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, vehicle):
        with console.socket("frames") as frames, console.socket("commands") as commands:
            page = Page(frames)
            page.until(is_ours, "the line of commands")
            said(commands, do="take")
            assert heard(commands, "acknowledged", "refused")["is"] == "acknowledged"
        soon(lambda: not vehicle.commands.is_open, "the line is closed")
        assert pi.server is not None
        soon(lambda: "@ACK_AC" in str(asked_clear(pi)), "another may command")


def asked_clear(pi: Running) -> bytes:
    with pi.boat() as boat:
        boat.sendall(b"@AC$")
        return boat.recv(100)


# --- X and W --------------------------------------------------------------------------------------


@pytest.mark.proof
def test_x_is_obeyed_however_old_and_while_an_upload_is_under_way(tmp_path: Path) -> None:
    rows = "".join(f"a{n}: heading 90 gear 4 for 2s\n" for n in range(60))
    text = TEXT.replace("up: ", f"{rows}up: ")
    with (
        at_sea(tmp_path) as (_pi, console, _),
        console.socket("frames") as frames,
        console.socket("commands") as commands,
        console.socket("orders") as orders,
    ):
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        page.until(lambda s: s.get("report_at") is not None, "reports")
        said(commands, do="upload", text=text, source="long.mission")
        assert heard(commands, "progress", "refused", "acknowledged")["is"] == "progress"
        said(orders, do="stop", at=time.time() - HOUR)
        assert heard(orders, "sent", "refused")["is"] == "sent"
        first = heard(orders, "acknowledged", "unanswered")
        assert first["is"] == "acknowledged"
        page.until(lambda s: s["state"] == "emergency/stopped", "stopped")
        assert heard(orders, "confirmed", "unconfirmed", "contradicted")["is"] == "confirmed"
        (row,) = page.until(lambda s: s["orders"][-1]["is"] == "confirmed", "told")["orders"]
        assert row["order"] == "stop"


def test_an_order_waits_for_a_vehicle_out_of_reach_and_outlives_its_page(tmp_path: Path) -> None:
    url = f"tcp://127.0.0.1:{free_port()}"
    with simulated_board(1.0) as sea, console_of(url, tmp_path) as (console, _vehicle):
        with console.socket("orders") as orders:
            said(orders, do="surface", at=0)
            assert heard(orders, "sent")["is"] == "sent"
        time.sleep(0.5)
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, gps=gps, topside=url), console.socket("frames") as frames:
            page = Page(frames)
            page.until(lambda s: str(s.get("state")).startswith("emergency/surf"), "surfacing")
            page.until(
                lambda s: s["orders"][0]["is"] in ("acknowledged", "confirmed"), "acknowledged"
            )


def test_a_newer_order_takes_the_place_of_one_that_nobody_has_answered(tmp_path: Path) -> None:
    with (
        console_of("tcp://127.0.0.1:1", tmp_path) as (console, _),
        console.socket("orders") as orders,
    ):
        said(orders, do="stop", id=1)
        assert heard(orders, "sent")["id"] == 1
        said(orders, do="surface", id=2)
        gone = heard(orders, "refused")
        assert (gone["id"], "newer order" in gone["says"]) == (1, True)


def test_an_order_that_a_page_says_again_takes_no_newer_ones_place(tmp_path: Path) -> None:
    with console_of("tcp://127.0.0.1:1", tmp_path) as (console, vehicle):
        at = time.time()
        with console.socket("orders") as lost:
            said(lost, do="stop", id=1, at=at)
            heard(lost, "sent")
        with console.socket("orders") as other, console.socket("orders") as again:
            said(other, do="surface", id=1, at=at)
            heard(other, "sent")
            said(again, do="stop", id=1, at=at)
            heard(again, "sent", "unanswered", "refused")
            assert [o["order"] for o in vehicle.orders.as_objects(0.0)] == ["stop", "surface"]
            said(again, do="stop", id=2, at=at)
            heard(again, "sent")
            assert vehicle.orders.as_objects(0.0)[-1]["order"] == "stop"


# --- the stick ------------------------------------------------------------------------------------


def drive(stick: object, page: Page, until: object, **more: object) -> None:
    """Axes ten times a second, until something holds of the state."""
    over = threading.Event()

    def push() -> None:
        while not over.wait(0.1):
            said(stick, **{"surge": 0.5, "turn": 0.0, "heave": 0.0, **more})  # type: ignore[arg-type]

    pushing = threading.Thread(target=push)
    pushing.start()
    try:
        page.until(until, "driven")  # type: ignore[arg-type]
    finally:
        over.set()
        pushing.join(PATIENCE)


def test_a_stick_drives_and_what_is_let_go_stops_within_two_seconds(tmp_path: Path) -> None:
    with at_sea(tmp_path) as (_, console, _), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        page.until(lambda s: s.get("report_at") is not None, "reports")
        with console.socket("stick") as stick:
            drive(stick, page, lambda s: s["state"] == "manual/driving")
            heard(stick, "driving")
            began = page.t
            page.until(lambda s: s["state"] == "manual/waiting", "let go")
            assert page.t - began < 3.5  # the last axes 0.5 s, R6 2 s, and a frame


def test_a_stick_whose_page_is_gone_lets_go(tmp_path: Path) -> None:
    with at_sea(tmp_path) as (_, console, _), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        page.until(lambda s: s.get("report_at") is not None, "reports")
        with console.socket("stick") as stick:
            drive(stick, page, lambda s: s["state"] == "manual/driving")
        page.until(lambda s: s["state"] == "manual/waiting", "let go")


def test_axes_older_than_half_a_second_move_nothing(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (_, console, vehicle), console.socket("frames") as frames:
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("stick") as stick:
            for age in (0.6, 5.0, -HOUR):
                said(stick, surge=1.0, turn=0.0, heave=0.0, at=time.time() - age)
            assert heard(stick, "ready", "driving")["is"] == "ready"
            time.sleep(0.5)
            assert vehicle.commands.sent == b""


def test_a_stick_moves_nothing_while_another_commands_or_nobody_answers(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (pi, console, vehicle), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        with pi.boat() as other, console.socket("stick") as stick:
            other.sendall(b"@AC$")
            page.until(lambda s: s["command"]["is"] == "other", "another")
            said(stick, surge=1.0, turn=0.0, heave=0.0)
            assert "another commands" in heard(stick, "refused")["says"]
            assert vehicle.commands.sent == b""
    with (
        console_of("tcp://127.0.0.1:1", tmp_path) as (console, vehicle),
        console.socket("stick") as stick,
    ):
        said(stick, surge=1.0, turn=0.0, heave=0.0)
        assert "does not answer" in heard(stick, "refused")["says"]


def test_x_takes_the_stick_and_it_need_not_wait_for_the_command(tmp_path: Path) -> None:
    """R12 gives the command to who gave the order: that connection is left at once."""
    with at_sea(tmp_path) as (_, console, _), console.socket("frames") as frames:
        page = Page(frames)
        page.until(is_ours, "the line of commands")
        page.until(lambda s: s.get("report_at") is not None, "reports")
        with console.socket("stick") as stick, console.socket("orders") as orders:
            drive(stick, page, lambda s: s["state"] == "manual/driving")
            said(orders, do="stop")
            page.until(lambda s: s["state"] == "emergency/stopped", "stopped")
            said(stick, held=False)
            began = page.t
            page.until(lambda _: page.t > began + 2.5, "2 s in which every stick is still (R6)")
            drive(stick, page, lambda s: s["state"] == "manual/driving")
            assert page.t - began < 9.0  # and not the 10 s of R12


def test_two_pages_do_not_share_a_stick(tmp_path: Path) -> None:
    with cockpit(tmp_path) as (_, console, _), console.socket("frames") as frames:
        Page(frames).until(is_ours, "the line of commands")
        with console.socket("stick") as first, console.socket("stick") as second:
            for _ in range(3):
                said(first, surge=0.5, turn=0.0, heave=0.0)
            heard(first, "driving")
            said(first, surge=0.5, turn=0.0, heave=0.0)
            assert "another page" in heard(second, "refused")["says"]


def test_a_page_that_answers_nothing_is_sent_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.onboard.serve.monitor.SILENT_S", 0.5)
    with console_of("tcp://127.0.0.1:1", tmp_path) as (console, vehicle):
        with console.socket("frames") as frames, pytest.raises(ConnectionClosed):
            deque(frames, 0)
        soon(lambda: vehicle.board.pages == 0, "the page is forgotten")


@pytest.mark.proof
def test_a_mission_that_runs_is_watched_to_its_leg(tmp_path: Path) -> None:
    with at_sea(tmp_path) as (pi, console, _), console.socket("frames") as frames:
        page = Page(frames)
        converse(pi.url, upload(script(MISSION), digest(MISSION), quiet))
        converse(pi.url, start(patience=int(PATIENCE)))
        state = page.until(lambda s: s.get("leg") == "dive", "the leg")
        assert state["leg_ends"][0][0] == "depth >= 2.5 m"
        page.until(lambda s: s.get("ellipse") is not None and len(page.track) > 2, "the track")
        page.until(lambda _: any("entry of dive" in line for line in page.events), "the journal")
