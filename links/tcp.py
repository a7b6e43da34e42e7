"""TCP, never blocking: one peer as a client, many as a server.

    tcp://host:port              connects at once; LinkAbsent if nobody answers
    tcp-listen://host:port       port 0: any free one, see ``port``; peers by address "host:port"

A server's ``fileno`` is that of a selector over all its sockets, so that an event loop watches one
number. Bytes that a peer does not take wait for it; a peer with more than ``BACKLOG`` waiting is
dropped, and so are new peers beyond ``PEERS``. A peer that went away is found by ``send`` (raises
LinkClosed) and by ``peers``. What does not live here: who may command (mission).
"""

from __future__ import annotations

import errno
import os
import selectors
import socket
from dataclasses import dataclass, field

from links import Address, LinkAddressError
from links.base import Link, LinkAbsent, LinkBusy, LinkClosed, LinkError, Rx

BACKLOG = 1 << 20  # bytes waiting for one peer
PEERS = 64
CONNECT_TIMEOUT = 5.0  # s
_CHUNK = 65536
_AGAIN = (BlockingIOError, InterruptedError)


def _address(sockaddr: tuple[object, ...]) -> str:
    host, port = sockaddr[0], sockaddr[1]
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"


@dataclass(slots=True)
class _Peer:
    """One connection: what has come, what still has to go."""

    socket: socket.socket
    address: str
    waiting: bytearray = field(default_factory=bytearray)
    ended: bool = False

    def read(self) -> bytes:
        """All there is; sets ``ended`` when the other side is gone."""
        out = bytearray()
        while True:
            try:
                data = self.socket.recv(_CHUNK)
            except _AGAIN:
                break
            except OSError:
                self.ended = True
                break
            if not data:
                self.ended = True
                break
            out += data
            if len(data) < _CHUNK:
                break
        return bytes(out)

    def write(self, data: bytes = b"") -> None:
        self.waiting += data
        while self.waiting and not self.ended:
            try:
                sent = self.socket.send(self.waiting)
            except _AGAIN:
                break
            except OSError:
                self.ended = True
                break
            del self.waiting[:sent]
        if len(self.waiting) > BACKLOG:
            self.ended = True


class TcpClient:
    def __init__(self, name: str, host: str, port: int) -> None:
        self.name = name
        self._where = f"{host}:{port}"
        try:
            connected = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT)
        except OSError as error:
            raise LinkAbsent(f"{name}: nobody answers at {self._where}: {error}") from error
        connected.setblocking(False)
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._peer = _Peer(connected, _address(connected.getpeername()))
        self._closed = False

    def fileno(self) -> int:
        return -1 if self._closed else self._peer.socket.fileno()

    def receive(self, now: float) -> list[Rx]:
        """What came before an end is handed out first; the next call raises LinkClosed."""
        self._check_open()
        self._peer.write()
        data = self._peer.read()
        if data:
            return [Rx(now, self.name, data, self._peer.address)]
        self._check_open()
        return []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self._check_open()
        self._peer.write(data)
        self._check_open()

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        self._closed = True
        self._peer.socket.close()

    def _check_open(self) -> None:
        if self._closed:
            raise LinkClosed(f"{self.name}: the link to {self._where} was closed")
        if self._peer.ended:
            self.close()
            raise LinkClosed(f"{self.name}: {self._where} closed the connection")


class TcpServer:
    def __init__(self, name: str, host: str, port: int, *, peers: int = PEERS) -> None:
        self.name = name
        self._most = peers
        self._peers: dict[str, _Peer] = {}
        self._selector = selectors.DefaultSelector()
        try:
            self._listener = socket.create_server((host, port), backlog=16)
        except OSError as error:
            self._selector.close()
            raise _why_not_listening(name, host, port, error) from error
        self._listener.setblocking(False)
        self.port = int(self._listener.getsockname()[1])
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._closed = False

    @property
    def peers(self) -> tuple[str, ...]:
        """Addresses of those who are connected, in the order in which they came."""
        return tuple(self._peers)

    def fileno(self) -> int:
        if self._closed:
            return -1
        number = getattr(self._selector, "fileno", None)
        return int(number()) if number else -1

    def receive(self, now: float) -> list[Rx]:
        self._check_open()
        out = []
        for key, _ in self._selector.select(timeout=0):
            if key.data is None:
                self._accept()
                continue
            peer: _Peer = key.data
            peer.write()
            data = peer.read()
            if data:
                out.append(Rx(now, self.name, data, peer.address))
            self._settle(peer)
        return out

    def send(self, data: bytes, now: float, address: str = "") -> None:
        """To one peer, or to all where no address is given."""
        self._check_open()
        if not address:
            for peer in list(self._peers.values()):
                peer.write(data)
                self._settle(peer)
            return
        one = self._peers.get(address)
        if one is not None:
            one.write(data)
            self._settle(one)
        if address not in self._peers:
            raise LinkClosed(f"{self.name}: {address} is not connected any more")

    def next_event(self) -> float | None:
        return None

    def drop(self, address: str) -> None:
        """Close one peer's connection, if it is still there."""
        peer = self._peers.pop(address, None)
        if peer is not None:
            self._selector.unregister(peer.socket)
            peer.socket.close()

    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        for address in self.peers:
            self.drop(address)
        self._selector.close()
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                connected, sockaddr = self._listener.accept()
            except _AGAIN:
                return
            except OSError as error:  # the peer left already, or there are no descriptors left
                if error.errno in (errno.EMFILE, errno.ENFILE):
                    return
                continue
            if len(self._peers) >= self._most:
                connected.close()
                continue
            connected.setblocking(False)
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
            peer = _Peer(connected, _address(sockaddr))
            self._peers[peer.address] = peer
            self._selector.register(connected, selectors.EVENT_READ, peer)

    def _settle(self, peer: _Peer) -> None:
        """Watch for room only while something waits; let go of who has left."""
        if peer.ended:
            self.drop(peer.address)
        elif peer.address in self._peers:
            write = selectors.EVENT_WRITE if peer.waiting else 0
            self._selector.modify(peer.socket, selectors.EVENT_READ | write, peer)

    def _check_open(self) -> None:
        if self._closed:
            raise LinkClosed(f"{self.name}: the server on port {self.port} was closed")


def _why_not_listening(name: str, host: str, port: int, error: OSError) -> LinkError:
    if error.errno == errno.EADDRINUSE:
        return LinkBusy(f"{name}: port {port} on {host} is in use by another program")
    if error.errno == errno.EACCES:
        return LinkBusy(f"{name}: port {port} needs more rights: take one above 1023")
    reason = os.strerror(error.errno) if error.errno else str(error)
    return LinkAbsent(f"{name}: cannot listen on {host}:{port}: {reason}")


def open_url(name: str, address: Address) -> Link:
    if not address.host or address.port is None or address.path not in ("", "/"):
        raise LinkAddressError(
            f"{address.url}: write {address.scheme}://host:port, e.g. "
            f"{address.scheme}://127.0.0.1:9000"
        )
    if address.scheme == "tcp-listen":
        return TcpServer(name, address.host, address.port)
    return TcpClient(name, address.host, address.port)
