"""Alarms of a running serve: in the journal when they begin and end, and over every path."""

from __future__ import annotations

import json
import os
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest
from click.testing import CliRunner
from served import PATIENCE, running, silent_board, simulated, soon

from mission.commands import operator
from mission.onboard.serve import alarm_watch, health
from mission.onboard.serve.alarm_watch import clock_off
from mission.topside.dives import FILE, Dives, default_folder
from protocol.messages import Fix


def told(url: str, *more: str) -> tuple[int, str]:
    ran = CliRunner().invoke(operator.status, ["--to", url, *more])
    return ran.exit_code, ran.stdout


def test_a_vehicle_whose_cable_is_out_is_told_in_journal_health_and_status(tmp_path: Path) -> None:
    with silent_board() as (_, board):
        device = tmp_path / "ttyAUV"
        device.symlink_to(board)
        with running(tmp_path, f"serial://{device}") as pi:
            device.unlink()
            soon(lambda: pi.has_told("ALARM old report: the vehicle's board"), "the alarm")
            soon(lambda: '"old report"' in (tmp_path / health.FILE).read_text(), "the health")
            status, text = told(pi.url, "--json")
            found = json.loads(text)
            assert status == operator.ALARM
            assert [alarm["name"] for alarm in found["alarms"]] == ["old report"]
            assert found["reports"].startswith("none")
            with pi.boat() as boat:
                boat.sendall(b"@ZAX0$")
                soon(lambda: pi.has_told("ALARM emergency: emergency/stopped"), "the emergency")
            status, text = told(pi.url)
            assert status == operator.ALARM
            assert text.startswith("ALARM emergency: emergency/stopped")
    assert told(pi.url)[0] == 1


def test_an_alarm_waits_for_no_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hangs, goes_on = threading.Event(), threading.Event()

    def hang(folder: Path, how: health.Health) -> None:
        hangs.set()
        assert goes_on.wait(PATIENCE)

    with silent_board() as (_, board), running(tmp_path, f"serial://{board}") as pi:
        monkeypatch.setattr(health, "write", hang)
        try:
            assert hangs.wait(PATIENCE)
            with pi.boat() as boat:
                boat.sendall(b"@ZAX0$")
                soon(lambda: pi.has_told("ALARM emergency: emergency/stopped"), "the emergency")
        finally:
            goes_on.set()


def test_what_serve_alone_sees_reaches_the_boat_and_its_end_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fault = ["no space left"]
    monkeypatch.setattr(alarm_watch, "recording_fault", lambda box: fault[0])
    with silent_board() as (_, board), running(tmp_path, f"serial://{board}") as pi:
        soon(lambda: "ALARM black box" in told(pi.url)[1], "the alarm on the boat")
        fault[0] = ""
        soon(lambda: pi.has_told("alarm over: black box"), "its end")
        assert "black box" not in told(pi.url)[1]
        assert pi.has_told("ALARM black box: no space left - ")


def test_a_boat_says_when_a_vehicle_is_overdue_and_where_to_search(tmp_path: Path) -> None:
    url = "tcp://127.0.0.1:9"
    folder = Path(os.environ["XDG_STATE_HOME"]) / "auvmission" / "boat"
    folder.mkdir(parents=True, exist_ok=True)
    plan = {"name": "a", "worst_s": 60.0, "range_m": 200.0, "current": 0.5, "home": [30.0, 120.0]}
    dive = {"started": 1000.0, "plan": plan, "contact": None}
    (folder / FILE).write_text(json.dumps({"plans": {}, "boats": {url: dive}}))
    try:
        status, text = told(url)
        assert status == 1
        assert "ALARM no contact: the vehicle does not answer; heard never" in text
        assert "ALARM OVERDUE: it was to be up" in text
        assert "30.00000 120.00000" in text
        status, text = told(url, "--json")
        names = [alarm["name"] for alarm in json.loads(text)["alarms"]]
        assert names == ["no contact", "OVERDUE"]
    finally:
        (folder / FILE).unlink()


def test_the_boat_knows_from_the_start_on_when_a_vehicle_is_due(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path, stm32, gps=gps, speed=4.0) as pi:
            url, dives = pi.url, Dives(default_folder())
            ran = CliRunner().invoke(operator.upload, ["float-test", "--to", url])
            assert ran.exit_code == 0, ran.output
            assert dives.of(url).due is None
            before = time.time()
            ran = CliRunner().invoke(operator.start, ["--to", url, "--wait", "60"])
            assert ran.exit_code == 0, ran.output
            dive = dives.of(url)
            assert dive.plan is not None
            assert dive.plan.name == "float-test"
            assert dive.due is not None
            assert dive.due >= before + dive.plan.worst_s
            told(url)
            assert dives.of(url).contact is not None
            CliRunner().invoke(operator.stop, ["--to", url])
        assert "ALARM no contact" in told(url)[1]
        assert "OVERDUE" not in told(url)[1], "not before its time"


def test_the_pis_clock_is_compared_with_a_fresh_fix_alone() -> None:
    noon = datetime(2025, 6, 1, 12, tzinfo=UTC).timestamp()
    fix = Fix(10.0, 0.5, 2.0, 1.0, utc="2025-06-01T12:00:00")
    assert clock_off(fix, 11.0, noon + 1.0) == 0.0
    assert clock_off(fix, 11.0, noon + 61.0) == 60.0
    assert clock_off(fix, 20.0, noon) is None
    assert clock_off(None, 20.0, noon) is None
    assert clock_off(Fix(10.0, 0.5, 2.0, 1.0), 11.0, noon) is None
