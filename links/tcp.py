"""TCP, never blocking: one peer as a client, many as a server.

    tcp://host:port              connects at once; LinkAbsent if nobody answers
    tcp-listen://host:port       port 0: any free one, see ``port``; peers by address "host:port"

A server's ``fileno`` is that of a selector over all its sockets, so an event loop watches one
descriptor. The URL's options say who may connect (admission); ``refusals`` returns who was refused
or dropped. Bytes that a peer does not take yet are kept; a peer with more than ``BACKLOG`` bytes
waiting is dropped. A lost peer shows in ``send`` (raises LinkClosed) and in ``peers``.
What does not live here: single connections (stream), TLS (tls), who may command (mission).
"""

from __future__ import annotations

import errno
import os
import selectors
import socket
import ssl
from collections import Counter

from links import Address, LinkAddressError
from links.admission import Admission, Gate, Present, Refusal, admission_of
from links.base import Link, LinkAbsent, LinkBusy, LinkClosed, LinkError, Rx
from links.stream import BACKLOG, Stream, in_words, tune

__all__ = ["BACKLOG", "TcpClient", "TcpServer", "host_and_port"]

CONNECT_TIMEOUT = 5.0  # s
STEPS = 4  # handshakes per receive, oldest first: they take CPU time while others wait
ACCEPTS = 4  # per receive: peers that have left free their places before the next ones
RECEIVE_BUFFER = 1 << 16  # bytes in the kernel per peer: at most so many precede an X or W
_UNWELCOME = "it admits nobody from here, or wants tls://; its journal says which"
_VIEWER = "its certificate is a viewer's: it may look at the monitor's port alone"
_REFUSALS = 64  # different ones that are counted separately


def _address(sockaddr: tuple[object, ...]) -> str:
    host, port = sockaddr[0], sockaddr[1]
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"


class TcpClient:
    def __init__(
        self,
        name: str,
        host: str,
        port: int,
        *,
        tls: ssl.SSLContext | None = None,
        handshake: float = CONNECT_TIMEOUT,
    ) -> None:
        self.name = name
        self._where = f"{host}:{port}"
        try:
            connected = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT)
        except OSError as error:
            why = error.strerror or error
            raise LinkAbsent(f"{name}: nobody answers at {self._where}: {why}") from error
        try:
            peer = _address(connected.getpeername())
        except OSError as error:  # reset as soon as it was connected
            connected.close()
            raise LinkAbsent(f"{name}: {self._where} closed the connection at once") from error
        if tls is not None:
            try:
                connected.settimeout(handshake)
                connected = tls.wrap_socket(connected, server_hostname=host)
            except OSError as error:
                connected.close()
                raise LinkAbsent(
                    f"{name}: {self._where} answers, but not as our vehicle: {in_words(error)}"
                ) from error
        tune(connected)
        self._peer = Stream(connected, peer)
        self._peer.established = True
        self._closed = self._answered = False

    def fileno(self) -> int:
        return -1 if self._closed else self._peer.socket.fileno()

    def receive(self, now: float) -> list[Rx]:
        """Return what has come. Bytes from before the end are returned first; then LinkClosed."""
        self._check_open()
        self._peer.write()
        data = self._peer.read()
        if data:
            self._answered = True
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
        self._peer.close()

    def _check_open(self) -> None:
        if self._closed:
            raise LinkClosed(f"{self.name}: the link to {self._where} was closed")
        if self._peer.ended:
            why = self._peer.why or ("" if self._answered else _UNWELCOME)
            why = why and f": {why}"
            self.close()
            raise LinkClosed(f"{self.name}: {self._where} closed the connection{why}")


class TcpServer:
    def __init__(
        self,
        name: str,
        host: str,
        port: int,
        *,
        admission: Admission | None = None,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        self.name = name
        self._admission = admission or Admission()
        self._gate = Gate(self._admission)
        self._tls = tls
        self.streams: dict[str, Stream] = {}
        self.turned_away: Counter[Refusal] = Counter()
        self.selector = selectors.DefaultSelector()
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            self._listener = socket.create_server((host, port), family=family, backlog=128)
        except OSError as error:
            self.selector.close()
            raise _why_not_listening(name, host, port, error) from error
        self._listener.setblocking(False)
        self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self.port = int(self._listener.getsockname()[1])
        self.selector.register(self._listener, selectors.EVENT_READ)
        self._closed = False

    @property
    def peers(self) -> tuple[str, ...]:
        """Addresses of the connected peers, in the order in which they connected."""
        return tuple(a for a, stream in self.streams.items() if stream.established)

    def refusals(self) -> Counter[Refusal]:
        """Who was refused or dropped, and how often, since the last call."""
        told, self.turned_away = self.turned_away, Counter()
        return told

    def fileno(self) -> int:
        if self._closed:
            return -1
        number = getattr(self.selector, "fileno", None)
        return int(number()) if number else -1

    def receive(self, now: float) -> list[Rx]:
        self._check_open()
        ready = [key.data for key, _ in self.selector.select(timeout=0)]
        streams = [stream for stream in ready if stream is not None]
        lobby = sorted((s for s in streams if not s.established), key=lambda s: s.came)
        out = []
        for stream in [s for s in streams if s.established] + lobby[:STEPS]:
            if stream.address not in self.streams:
                continue  # dropped a moment ago, to free its place for another
            if not stream.established:
                stream.handshake()
                if stream.established:
                    self._enter(stream, now)
            if stream.established and not stream.ended:
                stream.write()
                data = stream.read()
                if data:
                    stream.heard = now
                    out.append(Rx(now, self.name, data, stream.address))
            self._settle(stream)
        self._let_go(now)
        if None in ready:
            self._accept(now)
        return out

    def send(self, data: bytes, now: float, address: str = "") -> None:
        """Send to one peer, or to all if no address is given."""
        self._check_open()
        if not address:
            for peer in self.peers:
                self.streams[peer].write(data)
                self._settle(self.streams[peer])
            return
        one = self.streams.get(address)
        if one is not None and one.established:
            one.write(data)
            self._settle(one)
        if address not in self.streams:
            raise LinkClosed(f"{self.name}: {address} is not connected any more")

    def next_event(self) -> float | None:
        """When the next silent connection is due to be dropped."""
        return min((self._deadline(stream) for stream in self.streams.values()), default=None)

    def vouch(self, address: str) -> None:
        """Note that the peer has sent a valid frame: it has proved itself."""
        if address in self.streams:
            self.streams[address].proved = True

    def drop(self, address: str) -> None:
        """Close one peer's connection, if it is still there."""
        stream = self.streams.pop(address, None)
        if stream is not None:
            self.selector.unregister(stream.socket)
            stream.close()

    def close(self) -> None:
        if self._closed:
            return
        self._closed = True
        for address in tuple(self.streams):
            self.drop(address)
        self.selector.close()
        self._listener.close()

    def _accept(self, now: float) -> None:
        for _ in range(ACCEPTS):
            try:
                connected, sockaddr = self._listener.accept()
            except BlockingIOError:
                return
            except OSError as error:  # the peer has left already, or no descriptors are left
                if error.errno in (errno.EMFILE, errno.ENFILE):
                    return
                continue
            why = self._admit(connected, sockaddr, now)
            if why:
                self._refuse(str(sockaddr[0]), why)
                connected.close()

    def _admit(self, connected: socket.socket, sockaddr: tuple[object, ...], now: float) -> str:
        """Admit a connection. Return why not; "" if it was admitted."""
        host = str(sockaddr[0])
        if why := self._gate.forbids(host):
            return why
        if self._tls is None:
            if why := self._gate.hurries(host, now) or self._make_room(host, now):
                return why
        else:
            self._give_way(self._gate.lobby(self._present(established=False)))
        try:
            tune(connected)
            if self._tls is not None:
                connected = self._tls.wrap_socket(
                    connected, server_side=True, do_handshake_on_connect=False
                )
        except OSError as error:
            return in_words(error)
        stream = Stream(connected, _address(sockaddr), host, now)
        self.streams[stream.address] = stream
        self.selector.register(connected, selectors.EVENT_READ, stream)
        return ""

    def _enter(self, stream: Stream, now: float) -> None:
        """Take a peer from the lobby into the connected ones, or end it with the reason."""
        stream.established = False
        may = self._admission.viewers or not stream.is_viewer
        stream.why = self._make_room(stream.host, now) if may else _VIEWER
        stream.established, stream.ended = True, bool(stream.why)

    def _make_room(self, host: str, now: float) -> str:
        """Free a place if need be. Return why none is free; "" if one is now."""
        gives_way, why = self._gate.room(host, self._present(established=True), now)
        self._give_way(gives_way)
        return why

    def _give_way(self, address: str) -> None:
        if address:
            self._refuse(self.streams[address].host, "silent, and its place was needed")
            self.drop(address)

    def _present(self, established: bool) -> list[Present]:
        return [
            Present(s.address, s.host, s.heard if s.proved else s.came, s.proved)
            for s in self.streams.values()
            if s.established == established
        ]

    def _settle(self, stream: Stream) -> None:
        """Watch for writability only while bytes wait. Drop a stream that has ended."""
        if stream.ended:
            if stream.why:
                self._refuse(stream.host, stream.why)
            self.drop(stream.address)
        elif stream.address in self.streams:
            write = selectors.EVENT_WRITE if stream.waiting else 0
            self.selector.modify(stream.socket, selectors.EVENT_READ | write, stream)

    def _deadline(self, stream: Stream) -> float:
        return stream.heard + (
            self._admission.idle if stream.established else self._admission.handshake
        )

    def _let_go(self, now: float) -> None:
        for stream in [s for s in self.streams.values() if self._deadline(s) <= now]:
            idle = f"silent for {self._admission.idle:g} s"
            self._refuse(stream.host, idle if stream.established else "it did not say who it is")
            self.drop(stream.address)

    def _refuse(self, host: str, why: str) -> None:
        refusal = Refusal(host, why)
        if refusal not in self.turned_away and len(self.turned_away) >= _REFUSALS:
            refusal = Refusal("others", "refused")
        self.turned_away[refusal] += 1

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


def host_and_port(address: Address) -> tuple[str, int]:
    """Host and port of a URL. Raises LinkAddressError."""
    if not address.host or address.port is None or address.path not in ("", "/"):
        raise LinkAddressError(
            f"{address.url}: write {address.scheme}://host:port, e.g. "
            f"{address.scheme}://127.0.0.1:9000"
        )
    return address.host, address.port


def settings(address: Address) -> tuple[str, int, Admission]:
    """Host, port and, for a server, who may connect. Raises LinkAddressError."""
    return *host_and_port(address), admission_of(address)


def open_url(name: str, address: Address) -> Link:
    host, port, admission = settings(address)
    if address.scheme == "tcp-listen":
        return TcpServer(name, host, port, admission=admission)
    return TcpClient(name, host, port)
