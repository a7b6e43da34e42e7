"""A Chromium on a screen of its own, driven by its own protocol alone.

Playwright has every page that it drives believe that it is seen and has the focus, whatever lies in
front of it; without a screen no tab is ever hidden. So this one is told by nobody but the browser.
"""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from browser_world import CHROMIUM, FLAGS
from served import PATIENCE, soon
from websockets.sync.client import ClientConnection, connect

ON_A_SCREEN = pytest.mark.skipif(
    shutil.which("Xvfb") is None, reason="no Xvfb here: apt-get install xvfb"
)
SHIFT, KEYS = 8, {"Shift": ("ShiftLeft", 16), "ArrowUp": ("ArrowUp", 38)}
SEEN = "document.visibilityState + (document.hasFocus() ? ', in front' : '')"


class Tabs:
    """The tabs of one window; ``at`` is the first of them."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._numbers = socket, itertools.count(1)
        (first,) = (
            one
            for one in self._browser("Target.getTargets")["targetInfos"]
            if one["type"] == "page"
        )
        self.at = first["targetId"]
        self._session = self._browser("Target.attachToTarget", targetId=self.at, flatten=True)

    def _browser(self, method: str, **said: object) -> dict[str, Any]:
        return self._ask({"method": method, "params": said})

    def _page(self, method: str, **said: object) -> dict[str, Any]:
        return self._ask({"method": method, "params": said} | self._session)

    def _ask(self, asked: dict[str, object]) -> dict[str, Any]:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number} | asked))
        while (answer := json.loads(self._socket.recv(PATIENCE))).get("id") != number:
            pass
        return dict(answer.get("result", {}))

    def evaluate(self, expression: str) -> Any:
        """None, too, before the page is there."""
        found = self._page("Runtime.evaluate", expression=expression)
        return found.get("result", {}).get("value")

    def shows(self, where: str, what: str) -> None:
        text = f"document.querySelector({where!r})?.textContent"
        soon(lambda: what in str(self.evaluate(text)), what)

    def click(self, where: str) -> None:
        self.evaluate(f"document.querySelector({where!r}).click()")

    def key(self, name: str, kind: str) -> None:
        """``kind``: keyDown, keyUp."""
        code, number = KEYS[name]
        self._page("Input.dispatchKeyEvent", type=kind, key=name, code=code, modifiers=SHIFT,
                   windowsVirtualKeyCode=number)  # fmt: skip

    def is_seen(self) -> str:
        return str(self.evaluate(SEEN))

    def another(self) -> str:
        """Opened in front of it."""
        return str(self._browser("Target.createTarget", url="about:blank")["targetId"])

    def close(self, tab: str) -> None:
        self._browser("Target.closeTarget", targetId=tab)


@contextmanager
def screen() -> Iterator[str]:
    """Its number as DISPLAY has it."""
    told, tells = os.pipe()
    words = ["Xvfb", "-displayfd", str(tells), "-screen", "0", "1400x900x24", "-nolisten", "tcp"]
    xvfb = subprocess.Popen(words, pass_fds=[tells], stderr=subprocess.DEVNULL)
    os.close(tells)
    with os.fdopen(told) as said:
        number = said.readline().strip()
    try:
        yield f":{number}"
    finally:
        xvfb.terminate()
        xvfb.wait(PATIENCE)


@contextmanager
def tabs_of(address: str, folder: Path) -> Iterator[Tabs]:
    """A Chromium with ``address`` open; ``folder``: where it keeps its own."""
    own = [f"--user-data-dir={folder}", "--remote-debugging-port=0", "--no-default-browser-check"]
    with screen() as display:
        chromium = subprocess.Popen(
            [str(CHROMIUM), *FLAGS, *own, address],
            env={**os.environ, "DISPLAY": display},
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            with connect(_listening(chromium), max_size=None) as socket:
                yield Tabs(socket)
        finally:
            chromium.kill()
            chromium.communicate()


def _listening(chromium: subprocess.Popen[str]) -> str:
    assert chromium.stderr is not None
    for line in chromium.stderr:
        if found := re.search(r"ws://\S+", line):
            return found[0]
    raise AssertionError("Chromium ended before it listened")
