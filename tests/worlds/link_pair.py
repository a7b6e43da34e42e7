"""Two links that hear each other, opened by their URLs, for any scheme of the table.

Most schemes meet by a name: both ends open the same URL. Those that do not are in MEETINGS. The far
end of a serial port is the other side of a pseudo-terminal; a CAN bus is one by UDP multicast where
this computer has it, else python-can's virtual one, and what others say there is left out.
"""

from __future__ import annotations

import atexit
import functools
import os
import shutil
import socket
import tempfile
import tty
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from patience import until

from links import LINKS, open_link
from links.base import Link, Rx
from links.tcp import TcpServer
from mission.onboard.serve.keys import make_keys

LATER = 100.0  # s: a link in virtual time has delivered by then
_GROUP, _PORT = "239.74.163.9", 43113
_HEAD = 3  # bytes of a record: identifier, size


class Pair:
    """``near`` and ``far``, as bytes: a link that carries records packs and unpacks them."""

    def __init__(self, near: Link, far: Link) -> None:
        self.near, self.far = near, far

    def send(self, sender: Link, data: bytes, now: float = 0.0) -> None:
        sender.send(data, now)

    def receive(self, receiver: Link, now: float = LATER) -> list[Rx]:
        return receiver.receive(now)

    def read(self, receiver: Link, wanted: int) -> bytes:
        """At least so many bytes, from whoever."""
        data = bytearray()

        def enough() -> bool:
            data.extend(b"".join(rx.data for rx in self.receive(receiver)))
            return len(data) >= wanted

        until(enough)
        return bytes(data)


class Records(Pair):
    """Of CAN: each end has an identifier of its own, by which its records are told from others."""

    def __init__(self, near: Link, far: Link) -> None:
        super().__init__(near, far)
        mark = os.getpid() & 0xFF
        self._said = {near: 0x100 | mark, far: 0x200 | mark}

    def send(self, sender: Link, data: bytes, now: float = 0.0) -> None:
        head = self._said[sender].to_bytes(2, "big")
        parts = [data[at : at + 8] for at in range(0, len(data), 8)]
        super().send(sender, b"".join(head + bytes([len(p)]) + p for p in parts), now)

    def receive(self, receiver: Link, now: float = LATER) -> list[Rx]:
        other = self._said[self.far if receiver is self.near else self.near].to_bytes(2, "big")
        heard = [rx for rx in super().receive(receiver, now) if rx.data.startswith(other)]
        return [rx._replace(data=rx.data[_HEAD:]) for rx in heard]


class _Fd:
    """The master side of a pseudo-terminal, as a link."""

    def __init__(self, fd: int) -> None:
        self.name, self._fd = "far", fd
        os.set_blocking(fd, False)

    def fileno(self) -> int:
        return self._fd

    def receive(self, now: float) -> list[Rx]:
        try:
            return [Rx(now, self.name, os.read(self._fd, 65536))]
        except BlockingIOError:
            return []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        os.write(self._fd, data)

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
        self._fd = -1


@contextmanager
def linked(scheme: str) -> Iterator[Pair]:
    with ExitStack() as stack:
        pair = MEETINGS.get(scheme, _by_name)(scheme, stack)
        stack.callback(pair.far.close)
        stack.callback(pair.near.close)
        yield pair


def _by_name(scheme: str, stack: ExitStack) -> Pair:
    url = LINKS[scheme].example
    return Pair(open_link("near", url), open_link("far", url))


def _acoustic(scheme: str, stack: ExitStack) -> Pair:
    url = "acoustic://contract?range=100&rate=100000"  # its example loses what it says
    return Pair(open_link("near", url), open_link("far", url))


def _serial(scheme: str, stack: ExitStack) -> Pair:
    master, slave = os.openpty()
    tty.setraw(slave)
    stack.callback(os.close, slave)
    return Pair(open_link("near", f"serial://{os.ttyname(slave)}?baud=9600"), _Fd(master))


def _can(scheme: str, stack: ExitStack) -> Pair:
    url = f"can://{_GROUP}?interface={'udp_multicast' if multicast() else 'virtual'}"
    return Records(open_link("near", url), open_link("far", url))


def _connected(scheme: str, stack: ExitStack) -> Pair:
    kind, secret = scheme.removesuffix("-listen"), scheme.startswith("tls")
    ours, theirs = (f"?keys={_keys()}/{who}" if secret else "" for who in ("vehicle", "boat"))
    listens = scheme.endswith("-listen")
    names = ("near", "far") if listens else ("far", "near")
    server = open_link(names[0], f"{kind}-listen://127.0.0.1:0{ours}")
    assert isinstance(server, TcpServer)
    client = _opened(names[1], server, f"{kind}://127.0.0.1:{server.port}{theirs}")
    until(lambda: bool(server.receive(0.0)) or bool(server.peers))
    return Pair(server, client) if listens else Pair(client, server)


def _opened(name: str, server: TcpServer, url: str) -> Link:
    """A client's end; a handshake needs the server to be turned meanwhile."""
    with ThreadPoolExecutor(1) as pool:
        opening = pool.submit(open_link, name, url)
        until(lambda: bool(server.receive(0.0)) or opening.done())
        return opening.result()


MEETINGS: dict[str, Callable[[str, ExitStack], Pair]] = {
    "serial": _serial,
    "acoustic": _acoustic,
    "can": _can,
    **dict.fromkeys(("tcp", "tcp-listen", "tls", "tls-listen"), _connected),
}


@functools.cache
def _keys() -> Path:
    if shutil.which("openssl") is None:
        pytest.skip("openssl makes the keys")
    folder = Path(tempfile.mkdtemp(prefix="auvmission-keys-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    make_keys(folder, ["boat"], lambda _: None)
    return folder


@functools.cache
def multicast() -> bool:
    """Whether this computer lets a program join a group."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.sendto(b"", (_GROUP, _PORT))
        except OSError:
            return False
    return True
