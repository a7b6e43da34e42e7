"""The configured links of `serve`: each is opened in a thread, watched, and reopened if lost.

    closed --open_link--> open --LinkClosed--> closed --RETRY_S--> ...
    switched off (@NS) --> closed, until switched on

The loss and return of an end of a joined link (links.joined) is reported as that of a port. A port
that is busy or absent is reported once, with the link's own message, and retried for ever, whatever
the error was; no error leaves this module. What does not live here: the meaning of the bytes
(runtime), the links.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections import Counter
from collections.abc import Callable

from links import baud_of, open_link
from links.admission import Refusal
from links.base import Link, LinkError, Rx
from links.joined import JoinedLink
from links.tcp import TcpServer
from mission.onboard.runtime.command_target import MODEM
from mission.onboard.serve.tx_spacer import BAUD, TxSpacer

RETRY_S = 1.0  # real time


class Port:
    """``readable`` is called when the link has bytes, ``changed`` when it opened or closed."""

    def __init__(
        self,
        name: str,
        url: str,
        readable: Callable[[Port], None],
        changed: Callable[[Port], None],
        tell: Callable[[str], None],
    ) -> None:
        self.name, self.url = name, url
        self._readable, self._changed, self._tell = readable, changed, tell
        self.link: Link | None = None
        self.received = self.sent = 0  # bytes
        self.heard: float | None = None  # when bytes last came, by the caller's clock
        self._told = ""
        self._spacer = TxSpacer(0.0, BAUD)
        self._closed, self._tried = asyncio.Event(), asyncio.Event()
        self._on = asyncio.Event()
        self._on.set()

    @property
    def peers(self) -> tuple[str, ...]:
        """The connected peers of a link that can have several; the one behind a modem has no
        address."""
        if isinstance(self.link, TcpServer):
            return self.link.peers
        return ("",) if self.link is not None and self.name == MODEM else ()

    @property
    def is_away(self) -> bool:
        """Whether the link is switched on, but it or an end of it could not be opened or was
        lost."""
        is_whole = self.link is not None and self._lacks is None
        return not is_whole and self._on.is_set() and bool(self._told)

    @property
    def _lacks(self) -> OSError | None:
        """Why an end of an open link is lost; None if it is not."""
        return self.link.away if isinstance(self.link, JoinedLink) else None

    def vouch(self, address: str) -> None:
        """Note that bytes of this peer made sense."""
        if isinstance(self.link, TcpServer):
            self.link.vouch(address)

    def drop_peer(self, address: str) -> None:
        """Close one peer's connection, where the link has several."""
        if isinstance(self.link, TcpServer):
            self.link.drop(address)

    def refusals(self) -> Counter[Refusal]:
        """Who was turned away or dropped, and how often, since the last call."""
        return self.link.refusals() if isinstance(self.link, TcpServer) else Counter()

    async def keep_open(self) -> None:
        """Run until cancelled."""
        try:
            while True:
                await self._on.wait()
                try:
                    await self._open()
                except Exception as error:  # of any kind: nothing else would reopen it
                    self._complain(f"{_said(self.name, error)} - trying again")
                    self._tried.set()
                    self.close()
                if self._on.is_set():
                    await asyncio.sleep(RETRY_S)
        finally:
            self._tried.set()
            self.close()

    async def tried(self, seconds: float) -> None:
        """Wait until it is open or opening has failed once, at most ``seconds``."""
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._tried.wait(), seconds)

    async def _open(self) -> None:
        loop = asyncio.get_running_loop()
        self._closed.clear()
        link = await _wanted(loop.run_in_executor(None, open_link, self.name, self.url))
        if not self._on.is_set():
            link.close()
            return
        self._adopt(link)
        await self._closed.wait()

    def _adopt(self, link: Link) -> None:
        self.link = link
        if isinstance(link, TcpServer):
            self.url = re.sub(r":0(?=$|\?)", f":{link.port}", self.url)  # the same when reopened
        self._tell_open()
        self._tried.set()
        if link.fileno() >= 0:
            asyncio.get_running_loop().add_reader(link.fileno(), self._readable, self)
        self._changed(self)

    def _tell_open(self) -> None:
        if (error := self._lacks) is not None:
            self._complain(f"{error} - trying again")
        elif self._told:
            self._told = ""
            self._tell(f"{self.name}: {self.url} is open")

    def _look(self) -> None:
        """Check whether an end was lost or is back; report it once the current send is done."""
        if self.link is not None and bool(self._told) is (self._lacks is None):
            asyncio.get_running_loop().call_soon(self._follow)

    def _follow(self) -> None:
        was_away = bool(self._told)
        if self.link is not None:
            self._tell_open()
            if was_away and not self._told:
                self._changed(self)

    def keep_gaps(self, gap: float) -> None:
        """Keep a gap of ``gap`` s between any two frames that are sent."""
        self._spacer = TxSpacer(gap, baud_of(self.url, BAUD))

    def receive(self, now: float) -> list[Rx]:
        for frame in self._spacer.due(now):
            self._write(frame, now, "")
        if self.link is None:
            return []
        watched = self.link.fileno()
        try:
            heard = self.link.receive(now)
        except (LinkError, OSError) as error:
            self._lose(watched, error)
            return []
        self._look()
        if heard:
            self.heard = now
            self.received += sum(len(rx.data) for rx in heard)
            if heard[0].address and not isinstance(self.link, TcpServer):
                heard = [rx._replace(address="") for rx in heard]  # there is only one peer
        return heard

    def send(self, data: bytes, now: float, address: str) -> bool:
        """Send the bytes; False if they are lost because the link is closed."""
        if self.link is None:
            return False
        for frame in self._spacer.leaving(data, now):
            self._write(frame, now, address)
        return self.link is not None

    def _write(self, data: bytes, now: float, address: str) -> None:
        if self.link is None:
            return
        watched = self.link.fileno()
        try:
            self.link.send(data, now, address)
            self.sent += len(data)
            self._look()
        except (LinkError, OSError) as error:
            if not isinstance(self.link, TcpServer):  # else one peer is gone, not the link
                self._lose(watched, error)

    def next_event(self) -> float | None:
        """When to check although nothing came: a link without a descriptor, a peer's timeout, a
        frame that waits for its gap."""
        if self.link is None:
            return None
        events = (self.link.next_event(), self._spacer.next_event())
        return min((event for event in events if event is not None), default=None)

    def switch(self, on: bool) -> None:
        if on:
            self._on.set()
        else:
            self._on.clear()
            self.close()

    def close(self) -> None:
        if self.link is not None:
            self._drop(self.link.fileno())

    def _lose(self, watched: int, error: OSError) -> None:
        self._complain(f"{error} - trying again")
        self._drop(watched)

    def _drop(self, watched: int) -> None:
        """Close the link. ``watched``: its descriptor, unknown to a link that lost its device."""
        link, self.link = self.link, None
        self._spacer.clear()
        if watched >= 0:
            asyncio.get_running_loop().remove_reader(watched)
        if link is not None:
            with contextlib.suppress(OSError):
                link.close()
            self._closed.set()
            self._changed(self)

    def _complain(self, text: str) -> None:
        if text != self._told:
            self._told = text
            self._tell(text)


def _said(name: str, error: Exception) -> str:
    """The text of an error; a link's own error already names the link."""
    return str(error) if isinstance(error, OSError) else f"{name}: {error!r}"


async def _wanted(opening: asyncio.Future[Link]) -> Link:
    """Wait for a link that a thread opens; if the wait is cancelled, close the link as soon as it
    is open."""
    try:
        return await asyncio.shield(opening)
    except asyncio.CancelledError:
        opening.add_done_callback(_close)
        raise


def _close(opened: asyncio.Future[Link]) -> None:
    if opened.exception() is None:
        opened.result().close()
