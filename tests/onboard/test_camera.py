"""The node CAMERA is a process, and what is told of it is so."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from served import PATIENCE, asked, running, silent_board, soon


def test_the_camera_node_runs_its_command_and_stops_it(tmp_path: Path) -> None:
    flag = tmp_path / "camera.pid"
    command = f"sh -c 'echo $$ > {flag}; exec sleep 100'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        soon(lambda: flag.exists() and flag.read_text().strip() != "", "the camera")
        number = int(flag.read_text())
        os.kill(number, 0)
        assert os.getpriority(os.PRIO_PROCESS, number) == 10, "X and W come first"
        assert Path(f"/proc/{number}/oom_score_adj").read_text().strip() == "500"
        assert asked(boat, b"@NSOOCCCO$") == b"@ACK_NSS$"
        with pytest.raises(ProcessLookupError):
            os.kill(number, 0)


def test_a_camera_that_ends_by_itself_is_told_and_no_longer_called_open(tmp_path: Path) -> None:
    end = tmp_path / "end"
    command = f"sh -c 'while [ ! -e {end} ]; do sleep 0.05; done; exit 7'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        assert asked(boat, b"@NI$") == b"@ACK_NI\x33$"
        end.touch()
        soon(lambda: pi.has_told("exit code 7 by itself"), "the end")
        assert asked(boat, b"@NI$") == b"@ACK_NI\x23$"
        end.unlink()
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$", "and can be opened again"


def test_a_camera_that_fails_at_once_is_never_called_open(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mission.onboard.runtime.device_switches.CHANGED_WITHIN_S", 1.0)
    monkeypatch.setattr("mission.onboard.serve.processes.BEGINS_S", PATIENCE)
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera="false") as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSN$"
        soon(lambda: pi.has_told("exit code 1 at once"), "why")


def test_what_a_camera_started_ends_with_it(tmp_path: Path) -> None:
    flag = tmp_path / "child.pid"
    command = f"sh -c 'sleep 1000 & echo $! > {flag}; wait'"
    with (
        silent_board() as (_, device),
        running(tmp_path, f"serial://{device}", camera=command) as pi,
        pi.boat() as boat,
    ):
        assert asked(boat, b"@NSOOCCOO$") == b"@ACK_NSS$"
        soon(lambda: flag.exists() and flag.read_text().strip() != "", "the camera")
        number = int(flag.read_text())
        assert asked(boat, b"@NSOOCCCO$") == b"@ACK_NSS$"
        soon(lambda: not is_alive(number), "its child is gone, too")


def is_alive(number: int) -> bool:
    """A zombie that nobody collects is not."""
    try:
        state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
