"""Laws of a link that serve keeps open."""

from __future__ import annotations

import asyncio
import termios
import threading

import pytest
from patience import LONG

from links.base import LinkClosed, Rx
from links.joined import JoinedLink
from links.memory import MemoryLink
from mission.onboard.serve import ports
from mission.onboard.serve.ports import Port


def test_what_is_opened_after_nobody_waits_for_it_is_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """serve ends while a thread still opens its link."""
    begun, released = threading.Event(), threading.Event()
    opened: list[MemoryLink] = []

    def slowly(name: str, url: str) -> MemoryLink:
        begun.set()
        assert released.wait(60.0)
        opened.append(MemoryLink(name))
        return opened[-1]

    async def serve() -> None:
        port = Port("vehicle", "memory://late", lambda port: None, lambda port: None, print)
        keeping = asyncio.get_running_loop().create_task(port.keep_open())
        await asyncio.to_thread(begun.wait, 60.0)
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)
        released.set()

    monkeypatch.setattr(ports, "open_link", slowly)
    asyncio.run(serve())
    assert [link.closed for link in opened] == [True]


class Dry(MemoryLink):
    """One end of a joined link, whose peer may be gone."""

    is_gone = False

    def receive(self, now: float) -> list[Rx]:
        if self.is_gone:
            raise LinkClosed("its plug is out")
        return super().receive(now)


def test_an_end_of_a_joined_link_is_told_as_away_and_as_open_as_a_port_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And its coming back as that of a port: what holds has to be said again."""
    told: list[str] = []
    changes: list[bool] = []
    lines: list[Dry] = []

    def line() -> Dry:
        lines.append(Dry("vehicle"))
        return lines[-1]

    async def serve() -> None:
        port = Port(
            "vehicle",
            "can://x?sensors=y",
            lambda port: None,
            lambda port: changes.append(port.link is not None),
            told.append,
        )
        keeping = asyncio.get_running_loop().create_task(port.keep_open())
        await port.tried(60.0)
        assert (port.is_away, changes) == (False, [True])
        lines[0].is_gone = True
        port.receive(1.0)
        await asyncio.sleep(0)
        assert (port.is_away, changes) == (True, [True])
        now = 1.0
        while len(changes) < 2:
            now = port.next_event() or now
            port.receive(now)
            assert port.send(b"\xff", now, "")
            await asyncio.sleep(0.001)  # a thread opens it
        assert (port.is_away, changes) == (False, [True, True])
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    bus = MemoryLink("vehicle")
    monkeypatch.setattr(ports, "open_link", lambda name, url: JoinedLink(name, lambda: bus, line))
    asyncio.run(asyncio.wait_for(serve(), 60.0))
    assert told == ["its plug is out - trying again", "vehicle: can://x?sensors=y is open"]


@pytest.mark.parametrize(
    "error",
    [
        OSError(5, "Input/output error"),
        termios.error(5, "Input/output error"),
        RuntimeError("of whatever kind"),
    ],
)
def test_what_failed_to_open_is_opened_again_whatever_kind_of_error_it_was(
    monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    failures, told = [error], list[str]()

    def once(name: str, url: str) -> MemoryLink:
        if failures:
            raise failures.pop()
        return MemoryLink(name)

    async def serve() -> None:
        opened = asyncio.Event()
        port = Port("gps", "memory://x", lambda port: None, lambda port: opened.set(), told.append)
        keeping = asyncio.get_running_loop().create_task(port.keep_open())
        await asyncio.wait_for(opened.wait(), LONG)
        assert port.link is not None
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)

    monkeypatch.setattr(ports, "open_link", once)
    monkeypatch.setattr(ports, "RETRY_S", 0.0)
    asyncio.run(serve())
    assert [text.endswith(" - trying again") for text in told] == [True, False]
