"""The full-screen view of `auvmission watch`, for a terminal over ssh (Textual).

    x stop   w surface        one press, at once
    s start  c clear          a second press within ``CONFIRM_S``; the view says what will happen
    q end

What does not live here: the contents of the panels (panels), their sources (sources), the commands'
scripts (orders, upload).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.widgets import Footer, RichLog, Static

from mission.model.alarms import Alarm
from mission.topside import panels
from mission.topside.console import BrokenOff
from mission.topside.contacts import Contacts
from mission.topside.orders import order
from mission.topside.panels import Line
from mission.topside.port import Port
from mission.topside.sources import Source
from mission.topside.underwater import PREFIX
from mission.topside.upload import OperatorError, Script, clear, start_telling
from protocol.messages import Order

REFRESH_S = 0.25
CONFIRM_S = 5.0
STYLES = {"plain": "", "good": "green", "careful": "bold yellow", "bad": "bold white on red",
          "dim": "dim", "deep": "reverse"}  # fmt: skip


class WatchApp(App[None]):
    """``to``: where commands go, the operator's port; "" for none."""

    CSS = """
    #banner { height: auto; max-height: 8; }
    .panel { border: round $primary; height: auto; padding: 0 1; }
    Horizontal { height: auto; }
    Horizontal > Vertical { width: 3fr; height: auto; }
    #place { width: 2fr; }
    #journal { border: round $primary; height: 1fr; min-height: 4; }
    #said { height: 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("x", "order('STOP')", "STOP"),
        Binding("w", "order('SURFACE')", "SURFACE"),
        Binding("s", "ask('start')", "start"),
        Binding("c", "ask('clear')", "clear"),
        Binding("q", "quit", "end"),
    ]
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, source: Source, to: str, memory: Path) -> None:
        super().__init__()
        self.source, self._to, self._contacts = source, to, Contacts(to, memory)
        self._port = source.port or Port(to)
        self._known: frozenset[str] = frozenset()  # alarms for which the bell has rung
        self._shown = 0  # number of events shown
        self._asked: tuple[str, float] | None = None
        self.said = ""  # the result of the last command

    def compose(self) -> ComposeResult:
        yield Static(id="banner")
        with Horizontal():
            with Vertical():
                yield Static(id="state", classes="panel")
                yield Static(id="margins", classes="panel")
            yield Static(id="place", classes="panel")
        yield Static(id="depth", classes="panel")
        yield RichLog(id="journal", wrap=True, markup=False)
        yield Static(id="said")
        yield Footer()

    def on_mount(self) -> None:
        for name in ("state", "margins", "place", "depth", "journal"):
            self.query_one(f"#{name}").border_title = name
        self.title = "auvmission watch"
        threading.Thread(target=self.source.run, daemon=True).start()
        self.set_interval(REFRESH_S, self.show)
        self.show()

    def on_unmount(self) -> None:
        self.source.stopped.set()

    # --- shown -------------------------------------------------------------------------------

    def show(self) -> None:
        """Draw everything again from what the source knows now."""
        if not self.query("#banner"):  # the view is closing
            return
        watched, now = self.source.watched, time.monotonic()
        self._contacts.remember(watched, now)
        mine = self._contacts.alarms(watched, now, self.source.live)
        banner = list(panels.banner(watched, now, mine, self._contacts.silent_s))
        if self.source.problem:
            banner.insert(0, Line(self.source.problem, panels.CAREFUL))
        self._put("banner", banner)
        up_by = panels.due(self._contacts.due(), time.time())
        self._put("state", [*panels.state(watched, now), *up_by])
        self._put("margins", panels.margins(watched, now))
        self._put("place", panels.place(watched, now))
        self._put("depth", panels.strip(watched))
        self._ring([*mine, *(Alarm(**plain) for plain in watched.state.get("alarms") or ())])
        self._tell_events()
        self.query_one("#said", Static).update(Text(self._line()))

    def _ring(self, alarms: Iterable[Alarm]) -> None:
        names = frozenset(alarm.name for alarm in alarms)
        if names - self._known:
            self.bell()
        self._known = names

    def _tell_events(self) -> None:
        watched = self.source.watched
        log = self.query_one("#journal", RichLog)
        fresh = watched.told - self._shown
        if fresh > 0:
            for text in list(watched.events)[-fresh:]:
                log.write(Text(text, STYLES["careful"] if "ALARM" in text else ""), expand=True)
            self._shown = watched.told

    def _put(self, name: str, lines: Iterable[Line]) -> None:
        whole = Text()
        for number, line in enumerate(lines):
            whole.append("\n" * (number > 0) + line.text, STYLES[line.style])
        self.query_one(f"#{name}", Static).update(whole)

    def _line(self) -> str:
        if self._asked is not None and time.monotonic() > self._asked[1] + CONFIRM_S:
            self._asked, self.said = None, "nothing was said"
        return self.said

    # --- commands ----------------------------------------------------------------------------

    def action_order(self, name: str) -> None:
        """Send it at once; other requests never block it."""
        which = Order[name]
        script = order(which, self._tell, under_water=self._to.startswith(PREFIX))
        self._say(which.value, script, urgent=True)

    def action_ask(self, name: str) -> None:
        if self._asked is None or self._asked[0] != name:
            mission = self.source.watched.state.get("mission") or "no mission that is known"
            key = name[0]
            self._asked = name, time.monotonic()
            self.said = f"{name} {mission} on {self._to}? {key} again says so"
            return
        self._asked = None
        self._say(name, start_telling(self._contacts.started) if name == "start" else clear())

    def _say(self, name: str, script: Script, *, urgent: bool = False) -> None:
        if not (self._to and self.source.live):
            self.said = f"{name}: there is nobody to be told; this is not a live vehicle"
            return
        try:
            number = self._port.press(urgent=urgent)
        except OperatorError as error:
            self.said = f"{name}: {error}"
            return
        self.said = f"{name}: sent to {self._to} ..."
        args = (name, script, number, urgent)
        threading.Thread(target=self._converse, args=args, daemon=True).start()

    def _converse(self, name: str, script: Script, number: int, urgent: bool) -> None:
        try:
            told = self._port.say(script, number, urgent=urgent, tell=self._tell)
            self._tell(told or f"{name}: done")
        except BrokenOff:
            return  # the newer command has the status line
        except OperatorError as error:
            self._tell(f"{name}: {error}")

    def _tell(self, text: str) -> None:
        self.said = text
