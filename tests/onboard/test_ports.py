"""Laws of a link that serve keeps open."""

from __future__ import annotations

import asyncio
import threading

import pytest

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
