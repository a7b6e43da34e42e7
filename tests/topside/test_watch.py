"""`auvmission watch`: the same truth on a full screen, live, of a recording and simulated."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import os
import pty
import select
import signal
import struct
import sys
import termios
import time
import tty
from collections.abc import Callable
from fcntl import ioctl
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from later import Later
from served import PATIENCE, running, silent_board, soon

from mission.analysis.replay.playback import Playback
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.model.alarms import Alarm
from mission.onboard.runtime.records import ListRecorder
from mission.onboard.serve.viewing import Viewing
from mission.topside import panels
from mission.topside.contacts import Contacts
from mission.topside.looking import Looked
from mission.topside.monitor import Watched
from mission.topside.panels import BAD, CAREFUL, DIM, GOOD, PLAIN
from mission.topside.sources import Source, frame_of, from_frames, from_monitor, from_recording
from mission.verification.simulation.flight import fly
from protocol.messages import Fix, StateReport, Status, Telemetry

screen, widgets = Later("mission.topside.watch"), Later("textual.widgets")  # and textual
STATE = {
    "state": "autonomous/rises/down", "leg": "rises/down", "depth": 2.5, "latitude": 30.0,
    "longitude": 120.0, "ellipse": [6.6, 3.2, 95], "report_at": 99.0, "fix_at": 43.0, "alarms": [],
    "setpoint": "depth 2 m", "to_depth": [0.4, 5.0], "to_radius": [290.0, 300.0],
    "to_time": [4.0, 20.0], "to_voltage": [None, 10.0], "leg_began": 88.0, "leg_timeout": 60.0,
    "leg_ends": [["depth >= 3 m held 4 s", {"depth": 2.5}]],
}  # fmt: skip


def watched(now: float = 0.0, **other: object) -> Watched:
    known = Watched()
    known.take({"n": 1, "t": 100.0, "state": {**STATE, **other}}, now)
    return known


def texts(lines: object) -> str:
    return "\n".join(line.text for line in lines)  # type: ignore[attr-defined]


# --- panels --------------------------------------------------------------------------------------


def test_state_leg_and_guard_are_shown_with_their_progress() -> None:
    shown = texts(panels.state(watched(), 0.0))
    assert "autonomous/rises/down" in shown
    assert f"{panels.bar(0.2)} 12 of 60 s" in shown
    assert "depth >= 3 m held 4 s   now depth 2.5" in shown


def test_ages_grow_while_nothing_comes_and_old_values_say_so() -> None:
    fresh, later = texts(panels.place(watched(), 0.0)), texts(panels.place(watched(), 30.0))
    assert "report     1 s ago" in fresh
    assert "fix        57 s ago   OLD" in fresh
    assert "depth      2.5 m" in fresh.splitlines()
    assert "report     31 s ago   OLD" in later
    assert "depth      2.5 m   OLD" in later


def test_what_is_not_known_is_not_made_up() -> None:
    shown = texts(panels.place(watched(latitude=None, depth=None, fix_at=None), 0.0))
    assert "position   not known" in shown
    assert "depth      not known" in shown
    assert "fix        none so far" in shown
    assert texts(panels.strip(Watched())) == "depth: not known"


def test_a_margin_is_a_bar_that_warns_in_time() -> None:
    styles = [line.style for line in panels.margins(watched(), 0.0)]
    assert styles == [BAD, GOOD, CAREFUL, DIM]
    assert "0.4 m left of 5" in texts(panels.margins(watched(), 0.0))


def test_margins_of_an_old_report_are_old() -> None:
    depth, radius, _, voltage = panels.margins(watched(to_voltage=[1.0, 10.0]), 30.0)
    assert depth == ("depth    0.4 m left of 5   OLD", DIM)
    assert voltage == ("voltage  1 V left of 10   OLD", DIM)
    assert radius.style == GOOD


def test_silence_is_told_first_and_alarms_by_their_danger() -> None:
    alarm = {"name": "no fix", "level": "warning", "words": "w", "do": "d"}
    mine = (Alarm("OVERDUE", "danger", "since", "search"),)
    lines = list(panels.banner(watched(alarms=[alarm]), 9.0, mine))
    assert [line.text[:12] for line in lines] == ["NOTHING NEW ", "ALARM OVERDU", "ALARM no fix"]
    assert [line.style for line in lines] == [BAD, BAD, CAREFUL]
    assert texts(panels.banner(watched(), 0.0)) == "no alarm"
    nothing = "nothing has been heard of the vehicle since watch began"
    assert texts(panels.banner(Watched(), 0.0)) == nothing


def test_a_vehicle_under_water_is_silent_after_two_looks_that_failed_and_not_between_them() -> None:
    known = Watched()
    known.take({"n": 1, "t": 1.0, "state": {}}, 0.0)
    for to, quiet in (("modem+serial:///dev/ttyUSB0", 30.0), ("tcp://vehicle:4000", 4.0)):
        boat = Contacts(to, Path("/nonexistent"))
        for now, silent in ((quiet, False), (quiet + 6.0, True)):
            said = "NOTHING NEW" in texts(panels.banner(known, now, (), boat.silent_s))
            names = [str(alarm.name) for alarm in boat.alarms(known, now, True)]
            assert (said, len(names) > 0) == (silent, silent)


def test_without_an_answer_to_ae_nothing_is_of_now_and_the_last_fix_is_no_estimate() -> None:
    known = StateReport(
        "idle/ready", "nobody", 1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 2.0, 3, 4.0, 0, "", ""
    )
    told = Status(
        None, Fix(0.0, 0.5, 2.0, math.inf), Telemetry(0.0, depth=6.0, batteries=(12.0, 48.0))
    )
    shown = Watched()
    for t, state, what in ((5.0, known, "estimate"), (20.0, None, "last fix")):
        shown.take(frame_of(Looked(told, told, None, 0, state, 0.0), t), t)
        place = texts(panels.place(shown, t)).splitlines()
        old = "" if state else "   OLD"
        assert place[0].startswith(f"{what:10} 28.6")
        assert {f"depth      6 m{old}", f"battery    12 V{old}"} <= set(place)
    margins = texts(panels.margins(shown, 20.0)).splitlines()
    assert all(line.endswith("not known") for line in margins)


def test_when_it_is_up_at_the_latest_is_told_from_the_start_on() -> None:
    assert texts(panels.due(None, 0.0)) == ""
    (before,), (behind,) = panels.due(1600.0, 1000.0), panels.due(1600.0, 1660.0)
    assert (before.style, behind.style) == (PLAIN, CAREFUL)
    assert before.text.endswith("at the latest, in 10 min")
    assert behind.text.endswith("at the latest, 60 s ago")


@pytest.mark.parametrize(
    ("words", "to"),
    [
        ([], "tcp://127.0.0.1:4000"),
        (["tcp://vehicle:4001"], "tcp://vehicle:4000"),
        (["tls://10.0.0.8:7001?keys=mine"], "tls://10.0.0.8:7000?keys=mine"),
        (["tcp://vehicle:4001", "--to", "tcp://relay:9"], "tcp://relay:9"),
        (["--frames", "--to", "tcp://relay:9"], "tcp://relay:9"),
    ],
)
def test_x_goes_to_the_vehicle_that_is_watched(
    words: list[str], to: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = []

    class App:
        def __init__(self, source: Source, to: str, memory: Path) -> None:
            told.append(to)

        def run(self) -> None:
            """Nobody looks."""

    monkeypatch.setattr("mission.topside.watch.WatchApp", App)
    assert CliRunner().invoke(main, ["watch", *words]).exit_code == 0
    assert told == [to]


def test_the_strip_hangs_from_the_surface() -> None:
    known = watched()
    known.take({"n": 2, "t": 1.0, "track": [[0, 0, 0, 0.0], [1, 0, 0, 2.0], [2, 0, 0, 4.0]]}, 0.0)
    top, *_, bottom, words = [line.text for line in panels.strip(known)]
    assert (top[0], top[2]) == ("█", " ")
    assert (bottom[1], bottom[2]) == ("█", " ")
    assert words == "depth 0 to 4.0 m, the last 2 s"


# --- the app -------------------------------------------------------------------------------------


class Screen:
    def __init__(self, app: Any) -> None:
        self.app = app

    def text(self, name: str) -> str:
        return str(self.app.query_one(f"#{name}", widgets.Static).render())

    @property
    def journal(self) -> str:
        return "\n".join(
            line.text for line in self.app.query_one("#journal", widgets.RichLog).lines
        )


def driven(
    source: Source, to: str, memory: Path, play: Callable[[Screen, Callable[..., object]], object]
) -> None:
    """``play`` gets the screen, and what presses a key or waits until something holds."""

    async def main() -> None:
        app = screen.WatchApp(source, to, memory)
        async with app.run_test(size=(110, 44)) as pilot:

            async def do(key: str | Callable[[], bool]) -> None:
                if isinstance(key, str):
                    await pilot.press(key)
                    return
                end = time.monotonic() + PATIENCE
                while not key():
                    assert time.monotonic() < end, f"not in time: {app.said}"
                    await pilot.pause(0.05)

            await play(Screen(app), do)  # type: ignore[misc]

    asyncio.run(main())


@pytest.mark.proof
def test_a_live_vehicle_is_watched_and_stopped_with_one_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "mission.topside.watch.CONFIRM_S", PATIENCE
    )  # whatever else the machine has to do
    with (
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}", monitor="tcp://127.0.0.1:0") as pi,
    ):
        url = monitor_of(pi)

        async def play(screen: Screen, do: Callable[..., object]) -> None:
            await do(lambda: "idle/empty" in screen.text("state"))  # type: ignore[misc]
            await do("s")  # type: ignore[misc]
            assert screen.app.said.startswith("start no mission that is known on tcp://")
            assert not pi.has_told("refused"), "the first press says nothing to the vehicle"
            await do("s")  # type: ignore[misc]
            await do(lambda: "no mission is stored" in screen.app.said)  # type: ignore[misc]
            await do("x")  # type: ignore[misc]
            await do(lambda: "emergency/stopped" in screen.text("state"))  # type: ignore[misc]
            await do(lambda: "ALARM emergency" in screen.text("banner"))  # type: ignore[misc]
            await do(lambda: "now emergency/stopped" in screen.journal)  # type: ignore[misc]
            await do("w")  # type: ignore[misc]
            await do(lambda: "emergency/surfacing" in screen.text("state"))  # type: ignore[misc]

        driven(from_monitor(url), pi.url, tmp_path, play)


@pytest.mark.proof
def test_without_a_monitor_the_operators_port_is_asked(tmp_path: Path) -> None:
    with silent_board() as (_, board), running(tmp_path, f"serial://{board}") as pi:

        async def play(screen: Screen, do: Callable[..., object]) -> None:
            await do(lambda: "idle/empty" in screen.text("state"))  # type: ignore[misc]
            await do(lambda: "ALARM old report" in screen.text("banner"))  # type: ignore[misc]

        driven(from_frames(pi.url), pi.url, tmp_path, play)


def test_by_modem_x_leaves_at_the_first_press_also_while_a_look_has_the_port(
    tmp_path: Path,
) -> None:
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    url, heard = f"modem+serial://{os.ttyname(theirs)}?range=800&rate=600", bytearray()

    def has(word: bytes) -> bool:
        with contextlib.suppress(BlockingIOError):
            heard.extend(os.read(ours, 500))
        return word in heard

    async def play(_: Screen, do: Callable[..., object]) -> None:
        await do(lambda: has(b"@AE$"))  # type: ignore[misc]
        await do("x")  # type: ignore[misc]
        await do(lambda: has(b"@ZAX0$"))  # type: ignore[misc]

    driven(from_frames(url), url, tmp_path, play)


def test_a_vehicle_that_is_not_there_is_said_to_be_and_taken_when_it_comes(tmp_path: Path) -> None:
    async def play(screen: Screen, do: Callable[..., object]) -> None:
        await do(lambda: "nobody answers" in screen.text("banner"))  # type: ignore[misc]
        await do("x")  # type: ignore[misc]
        await do(lambda: "nobody answers" in screen.app.said)  # type: ignore[misc]

    driven(from_monitor("tcp://127.0.0.1:9"), "tcp://127.0.0.1:9", tmp_path, play)


def flown() -> list:  # type: ignore[type-arg]
    prepared, recorder = prepare("float-test"), ListRecorder()
    fly(prepared.mission, prepared.vehicle, "", 0, None, recorder)
    return recorder.records


@pytest.mark.proof
def test_a_recording_is_shown_as_it_was_and_commands_nobody(tmp_path: Path) -> None:
    async def play(screen: Screen, do: Callable[..., object]) -> None:
        await do(lambda: "rises/let_go" in screen.journal)  # type: ignore[misc]
        await do(lambda: "m left of 300" in screen.text("margins"))  # type: ignore[misc]
        await do("x")  # type: ignore[misc]
        assert "not a live vehicle" in screen.app.said
        await do(lambda: "the recording is over" in screen.text("banner"))  # type: ignore[misc]
        assert "idle/ready" in screen.text("state")
        assert "rises/let_go" in screen.journal

    driven(from_recording(Playback(flown()), 50.0), "", tmp_path, play)


@pytest.mark.proof
def test_a_playback_shows_the_state_of_its_time() -> None:
    played, known = Playback(flown()), Watched()
    seen = []
    for second in range(int(played.end) + 2):
        _, answers = known.receive(played.until(float(second)), 0.0)
        if answers:
            played.answer(answers)
        seen.append(known.state["state"])
    assert seen[0].startswith("idle")
    assert seen[-1] == "idle/ready"
    assert {"autonomous/rises/down", "autonomous/rises/let_go", "autonomous/up"} <= set(seen)
    assert known.plan[0].startswith("mission float-test")


def test_what_is_no_recording_is_refused() -> None:
    with pytest.raises(ValueError, match="no whole start record"):
        Playback([])


def monitor_of(pi: object) -> str:
    viewing: Viewing = pi.server.viewing  # type: ignore[attr-defined]
    soon(lambda: viewing.port.link is not None, "the monitor's port")
    return f"tcp://127.0.0.1:{viewing.port.link.port}"  # type: ignore[union-attr]


@pytest.mark.proof
def test_it_runs_in_a_real_terminal_and_ends_with_a_key() -> None:
    import pyte

    child, master = pty.fork()
    if child == 0:
        os.environ["TERM"] = "xterm-256color"
        words = [sys.executable, "-m", "mission", "watch", "float-test", "--speed", "20"]
        os.execv(sys.executable, words)
    ioctl(master, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 110, 0, 0))
    screen = pyte.Screen(110, 40)
    stream, end = pyte.ByteStream(screen), time.monotonic() + PATIENCE
    try:
        while "rises/let_go" not in "\n".join(screen.display):
            assert time.monotonic() < end, json.dumps(screen.display)
            if select.select([master], [], [], 0.2)[0]:
                stream.feed(os.read(master, 65536))
        assert any("margins" in row for row in screen.display)
        os.write(master, b"q")
        while os.waitpid(child, os.WNOHANG)[0] == 0:
            assert time.monotonic() < end, "it does not end"
            with contextlib.suppress(OSError):  # its end is gone
                if select.select([master], [], [], 0.1)[0]:
                    os.read(master, 65536)
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        os.close(master)
