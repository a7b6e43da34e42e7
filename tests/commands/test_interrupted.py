"""Ctrl-C ends a command and whatever works for it, without a word of Python."""

from __future__ import annotations

import signal
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from commanded import CODE, begun, group_of, interrupted
from served import PATIENCE, noted_processes, soon

from mission.cli import COMMANDS, main
from mission.verification.campaign import soak
from mission.verification.simulation import staged
from mission.verification.simulation.demo import Demo


def hears_interrupts(pid: int) -> bool:
    """Whether Ctrl-C reaches a process: it is neither blocked nor ignored."""
    status = dict(
        line.split(":\t", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines()
    )
    kept_out = int(status["SigBlk"], 16) | int(status["SigIgn"], 16)
    return not kept_out >> (signal.SIGINT - 1) & 1


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_that_is_interrupted_ends_with_exit_130_and_one_word(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt() -> None:
        raise KeyboardInterrupt

    found = main.get_command(click.Context(main), name)
    monkeypatch.setattr(found, "callback", interrupt)
    monkeypatch.setattr(found, "params", [])
    ran = CliRunner().invoke(main, [name])
    assert (ran.exit_code, ran.stdout, ran.stderr) == (CODE, "", "interrupted\n")


@pytest.mark.proof
def test_flights_in_several_processes_end_with_their_processes() -> None:
    call = ("-m", "mission", "faults", "--flights", "2000", "--workers", "2")
    with begun(*call) as process:
        soon(lambda: len(group_of(process)) >= 4, "both work, and who tracks what they share")
        assert interrupted(process) == (CODE, ["interrupted"])


@pytest.mark.proof
def test_flights_that_were_interrupted_are_kept_and_the_rest_flown_later(tmp_path: Path) -> None:
    kept = tmp_path / "kept.jsonl"
    call = ("-m", "mission", "faults", "--seed", "4", "--workers", "2", "--resume", str(kept))
    with begun(*call, "--flights", "2000") as process:
        soon(lambda: kept.exists() and kept.read_bytes().count(b"\n") > 4, "some have ended")
        assert interrupted(process) == (CODE, ["interrupted"])
    there = kept.read_bytes()
    assert there.endswith(b"\n")
    again = CliRunner().invoke(main, ["faults", "--seed", "4", "--flights", "6", *call[-2:]])
    anew = CliRunner().invoke(main, ["faults", "--seed", "4", "--flights", "6", "--on", "local"])
    assert again.stdout == anew.stdout
    assert kept.read_bytes().startswith(there)


@pytest.mark.proof
@pytest.mark.parametrize("after", [0, 3])
def test_jobs_that_never_end_do_not_outlive_who_wanted_them(after: int) -> None:
    """Interrupted while the processes begin, and while they work."""
    job = "import sys, time; print(flush=True); time.sleep(1e6)"
    code = (
        "from mission.verification.workers import results\n"
        "from mission.verification.workers.places import place\n"
        "if __name__ == '__main__':\n"
        "    print('begins', flush=True)\n"
        f"    jobs = [{job!r}, {job!r} + ' ']\n"
        "    for _ in results(exec, jobs, place('processes', 2)): pass\n"
    )
    with begun("-c", code) as process:
        assert process.stdout is not None
        for _ in range(after):
            process.stdout.readline()
        soon(lambda: bool(after) or len(group_of(process)) >= 2, "it begins")
        if after:
            assert [pid for pid in group_of(process) if hears_interrupts(pid)] == [process.pid]
        ended, said = interrupted(process)
    assert ended == -signal.SIGINT
    own = [line for line in said if line.startswith("Traceback")]
    assert len(own) == 1, "the script's own; its processes say nothing"


def test_a_soak_tells_what_it_found_until_it_was_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(soak, "try_out", interrupt)
    ran = CliRunner().invoke(main, ["faults", "--soak", "1"])
    assert ran.exit_code == CODE
    assert '"missions": 0' in ran.stdout


@pytest.mark.proof
def test_a_demonstration_waits_for_no_process_that_does_not_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started = noted_processes(monkeypatch)

    def operate(self: Demo, topside: str, events: object) -> None:
        for process in started:
            process.send_signal(signal.SIGSTOP)
        raise KeyboardInterrupt

    monkeypatch.setattr(Demo, "_operate", operate)
    monkeypatch.setattr(staged, "STOP_S", 100 * PATIENCE)
    ran = CliRunner().invoke(main, ["demo", "--out", str(tmp_path / "out")])
    assert ran.exit_code == CODE
    assert [process.returncode for process in started] == [-signal.SIGKILL] * 2
