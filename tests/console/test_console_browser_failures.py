"""What is lost while a hand is on the stick lets the vehicle go within the 2 s of R6.

Each in a real Chromium, against the real serve; the times are the vehicle's own, from its black box.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from browser_world import CHROMIUM, FLAGS, IN_A_BROWSER, Seat, seated
from cable import Cable, cable
from console_world import console_of, monitor_of
from programs import process
from screen_world import ON_A_SCREEN, tabs_of
from served import Running, running, simulated, soon

from mission.model import Record
from mission.onboard.blackbox import read_records
from mission.onboard.runtime.records import INPUTS, RX, STEP, read_rx, step_of
from mission.topside.helm import NEUTRAL

pytestmark = IN_A_BROWSER
SILENCE_S = 2.0  # R6
AT_ONCE_S = 0.5  # s from what it hears to what it does about it, on a busy machine
HANG = """(ms) => setTimeout(() => {
  for (const end = Date.now() + ms; Date.now() < end;);
}, 0)"""
PUSH = re.compile(rb"@M[MR][A-Z][1-9]")


@dataclass
class Sea:
    """A simulated vehicle, its serve, and the way that the console has to it."""

    folder: Path
    pi: Running
    way: Cable
    watching: Cable

    def away(self, do: str) -> None:
        for one in (self.way, self.watching):
            getattr(one, do)()


@contextmanager
def at_sea(folder: Path) -> Iterator[Sea]:
    with simulated(1.0) as board:
        stm32, gps = (f"serial://{path}" for path in board.paths)
        with (
            running(folder, stm32, gps=gps, monitor="tcp://127.0.0.1:0") as pi,
            cable(pi.url) as way,
            cable(monitor_of(pi)) as watching,
        ):
            yield Sea(folder, pi, way, watching)


def hold(seat: Seat, folder: Path) -> None:
    """Until the vehicle hears what this hand pushes, and not what a cable held back."""
    since = now(folder)
    for key in ("Shift", "ArrowUp"):
        seat.page.keyboard.down(key)
    soon(lambda: any(one.last > since + AT_ONCE_S for one in drives(folder)), "pushed")
    seat.shows("#state", "manual/driving")


@dataclass
class Drive:
    """``last``: the last push; ``late``: what the vehicle heard more than 2 s later and was driven
    still; ``gone``: when it was let go."""

    last: float = 0.0
    late: list[float] = field(default_factory=list)
    gone: float | None = None

    def hear(self, record: Record) -> None:
        if record.kind == RX and NEUTRAL in read_rx(record).data:
            self.gone = record.t  # by the console; the state follows
        elif record.kind == STEP and "manual/waiting" in step_of(record.payload).entered:
            self.gone = record.t
        elif record.kind in INPUTS and record.t > self.last + SILENCE_S:
            self.late.append(record.t)

    @property
    def is_in_time(self) -> bool:
        """What it hears first behind the 2 s lets it go; more may come at once with that."""
        if self.gone is None:
            return False
        return not self.late or self.gone - self.late[0] <= AT_ONCE_S


def drives(folder: Path) -> list[Drive]:
    """Each from its first push until it is let go."""
    (box,) = folder.rglob("*.mcap")
    found: list[Drive] = []
    for record in read_records(box):
        if record.kind == RX and PUSH.search(read_rx(record).data):
            if not found or found[-1].gone is not None:
                found.append(Drive())
            found[-1].last, found[-1].late = record.t, []
        elif found and found[-1].gone is None:
            found[-1].hear(record)
    return found


def now(folder: Path) -> float:
    (box,) = folder.rglob("*.mcap")
    *_, last = read_records(box)
    return last.t


def let_go(folder: Path, before: int = 0, since: float = 0.0) -> None:
    """Behind the first ``before`` drives there is one more; it is over, and stays so: a cable that
    was pulled gives at once what it held back, which R6 has the vehicle fly for 2 s."""

    def over() -> bool:
        found = drives(folder)
        return len(found) > before and found[-1].gone is not None and now(folder) > since

    soon(over, "let go")


def another_tab(seat: Seat, sea: Sea) -> Iterator[None]:
    """In front of it. Playwright would have every page believe that it has the focus."""
    told = seat.page.context.new_cdp_session(seat.page)
    told.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    other = seat.page.context.new_page()
    other.bring_to_front()
    yield
    seat.shows("#stick", "the page is not in front")
    other.close()
    seat.page.bring_to_front()


def a_page_that_hangs(seat: Seat, sea: Sea) -> Iterator[None]:
    seat.page.evaluate(HANG, 1000 * (SILENCE_S + 2))
    yield


def a_cable_pulled(seat: Seat, sea: Sea) -> Iterator[None]:
    sea.away("pull")
    yield
    seat.shows("#banner", "NOTHING NEW of the vehicle")
    sea.away("plug")


def the_radio_lost(seat: Seat, sea: Sea) -> Iterator[None]:
    sea.away("lose")
    yield
    seat.shows("#banner", "NOTHING NEW of the vehicle")
    sea.away("plug")


FAILURES = (another_tab, a_page_that_hangs, a_cable_pulled, the_radio_lost)


def test_whatever_is_lost_on_the_way_to_the_vehicle_lets_it_go_within_two_seconds(
    chromium: object, tmp_path: Path
) -> None:
    with (
        at_sea(tmp_path) as sea,
        console_of(sea.way.url, tmp_path / "boat", sea.watching.url) as (console, _),
        seated(chromium, console) as seat,
    ):
        seat.shows("#state", "idle")
        seat.shows("#commander", "nobody")
        seat.tab("Stick")
        seat.page.get_by_role("button", name="Take the stick").click()
        for failure in FAILURES:
            before = len(drives(tmp_path))
            hold(seat, tmp_path)
            over = failure(seat, sea)
            next(over)
            let_go(tmp_path, before)  # by itself: the keys are down
            next(over, None)
            seat.page.keyboard.up("ArrowUp")
            seat.page.keyboard.up("Shift")
            let_go(tmp_path, before, since=now(tmp_path) + SILENCE_S + AT_ONCE_S)
            seat.shows("#state", "manual/waiting")
        found = drives(tmp_path)
    assert len(found) >= len(FAILURES)
    assert all(one.is_in_time for one in found), found


@pytest.mark.parametrize("killed", ["browser", "console"])
def test_a_browser_or_a_console_that_is_killed_lets_the_vehicle_go_within_two_seconds(
    chromium: object, tmp_path: Path, killed: str
) -> None:
    browser = chromium.browser_type.launch(  # type: ignore[attr-defined]
        executable_path=CHROMIUM, args=list(FLAGS)
    )
    with at_sea(tmp_path) as sea, console_process(sea) as (console, address):
        page = browser.new_page(locale="en-GB")
        page.goto(address)
        seat = Seat(page)
        seat.shows("#state", "idle")
        seat.shows("#commander", "nobody")
        seat.drive()
        if killed == "browser":
            told = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")
            (own,) = (one["id"] for one in told["processInfo"] if one["type"] == "browser")
            os.kill(own, signal.SIGKILL)
        else:
            console.kill()
        let_go(tmp_path)
        (found,) = drives(tmp_path)
    browser.close()
    assert found.is_in_time, found


@ON_A_SCREEN
def test_a_tab_that_the_browser_hides_lets_the_vehicle_go_within_two_seconds(
    tmp_path: Path,
) -> None:
    with (
        at_sea(tmp_path) as sea,
        console_of(sea.way.url, tmp_path / "boat", sea.watching.url) as (console, _),
        tabs_of(console.address, tmp_path / "chromium") as tabs,
    ):
        tabs.shows("#state", "idle")
        tabs.shows("#commander", "nobody")
        tabs.click("#stick button")
        for key in ("Shift", "ArrowUp"):
            tabs.key(key, "keyDown")
        tabs.shows("#state", "manual/driving")
        soon(lambda: bool(drives(tmp_path)), "on record")
        (before,) = drives(tmp_path)
        assert (tabs.is_seen(), before.gone) == ("visible, in front", None)
        other = tabs.another()
        soon(lambda: tabs.is_seen() == "hidden", "hidden")
        let_go(tmp_path)  # by itself: the keys are down
        tabs.close(other)
        soon(lambda: tabs.is_seen() == "visible, in front", "seen again")
        tabs.shows("#state", "manual/waiting")
        tabs.key("ArrowUp", "keyDown")  # as a key that is still down tells itself again
        tabs.shows("#stick", "then hold it again")
        (found,) = drives(tmp_path)
    assert found.is_in_time, found


@contextmanager
def console_process(sea: Sea) -> Iterator[tuple[subprocess.Popen[str], str]]:
    words = ["--to", sea.pi.url, "--monitor", sea.watching.url, "--no-browser"]
    with process("console", *words) as console:
        assert console.stdout is not None
        yield console, console.stdout.readline().removeprefix("open ").strip()
