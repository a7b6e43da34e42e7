"""A real Chromium, and who sits before it. Without one the tests that import this are skipped."""

from __future__ import annotations

import contextlib
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from console_world import Console
from later import installed
from served import PATIENCE

playwright = installed("playwright.sync_api", "pip install playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
IN_A_BROWSER = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium here: apt-get install chromium"),
]
# A file of a name and a text is dropped on the plan.
DROP = """([name, text]) => {
  const carried = new DataTransfer();
  carried.items.add(new File([text], name));
  const drop = new DragEvent('drop', {dataTransfer: carried, bubbles: true, cancelable: true});
  document.getElementById('planner').dispatchEvent(drop);
}"""
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run",
         "--disable-sync", "--disable-component-update",
         "--host-resolver-rules=MAP evil.example 127.0.0.1")  # fmt: skip


@dataclass
class Seat:
    """A page, and what its browser said and asked for."""

    page: playwright.Page  # type: ignore[name-defined]
    said: list[str] = field(default_factory=list)
    hosts: set[str] = field(default_factory=set)

    def shows(self, where: str, what: str | re.Pattern[str]) -> None:
        playwright.expect(self.page.locator(where)).to_contain_text(what)

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name, exact=True).first.click()

    def press_twice(self, button: str) -> None:
        """What asks before it acts; it asks for some seconds only, which a busy machine may miss."""
        again = self.page.get_by_role("button", name=re.compile("^Press again"))
        for _ in range(10):
            self.page.get_by_role("button", name=button, exact=True).click()
            with contextlib.suppress(AssertionError, playwright.TimeoutError):
                playwright.expect(again).to_be_visible(timeout=3000)
                self.page.wait_for_timeout(400)  # two presses, and no double click
                again.click(timeout=3000)
                return
        raise AssertionError(f"{button} was never asked for again")

    def start(self) -> None:
        """It is refused while the filter is loaded, without a fix, and 2 s after the stick (R6)."""
        for _ in range(15):
            self.press_twice("Start")
            with contextlib.suppress(AssertionError):
                state = playwright.expect(self.page.locator("#state"))
                state.to_contain_text("autonomous/dive", timeout=3000)
                return
        raise AssertionError(self.page.locator("#command").inner_text())

    def drive(self) -> None:
        """By keys that stay down."""
        self.tab("Stick")
        self.page.get_by_role("button", name="Take the stick").click()
        self.page.keyboard.down("Shift")
        self.page.keyboard.down("ArrowUp")
        self.shows("#state", "manual/driving")


@contextmanager
def browser() -> Iterator[object]:
    playwright.expect.set_options(timeout=1000 * PATIENCE)
    with playwright.sync_playwright() as running:
        launched = running.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield launched
        launched.close()


@contextmanager
def seated(chromium: object, running: Console, **more: object) -> Iterator[Seat]:
    """It says nothing on its console, and asks no host but ours. ``more``: of the context."""
    size = {"width": 1400, "height": 900}
    asked = {"viewport": size, "locale": "en-GB"} | more
    context = chromium.new_context(**asked)  # type: ignore[attr-defined]
    context.set_default_timeout(1000 * PATIENCE)
    seat = Seat(context.new_page())
    seat.page.on("console", lambda message: seat.said.append(message.text))
    seat.page.on("pageerror", lambda error: seat.said.append(str(error)))
    seat.page.on("request", lambda request: seat.hosts.add(request.url.split("/")[2]))
    seat.page.on("websocket", lambda socket: seat.hosts.add(socket.url.split("/")[2]))
    seat.page.goto(running.address)
    try:
        yield seat
        assert (seat.said, seat.hosts) == ([], {running.host}), (seat.said, seat.hosts)
    finally:
        context.close()


def until(page: playwright.Page, holds: Callable[[], bool]) -> None:  # type: ignore[name-defined]
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        page.wait_for_timeout(20)
