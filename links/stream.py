"""One TCP connection that never blocks, plain or TLS, with the bytes that wait to be sent.

    handshaking --handshake()--> established --> ended (``why``: the reason; may be "")

TLS buffers bytes that a selector does not see, so ``read`` empties that buffer. One call reads
little more than ``READ`` bytes, so that a peer that floods does not delay the others.
"""

from __future__ import annotations

import contextlib
import socket
import ssl

BACKLOG = 1 << 18  # bytes waiting for one peer
ROLE, VIEWER = "organizationalUnitName", "viewer"  # in the subject of a certificate
READ = 8192  # bytes at a time
GIVEN_UP = 20_000  # ms that sent bytes may stay unacknowledged by TCP
KEEPALIVE = (10, 5, 3)  # s idle, s between probes, probes
_AGAIN = (BlockingIOError, InterruptedError, ssl.SSLWantReadError, ssl.SSLWantWriteError)

# OpenSSL's reasons in plain words; others are shown as they are
_REASONS = {
    "WRONG_VERSION_NUMBER": "it does not speak TLS",
    "HTTP_REQUEST": "it does not speak TLS",
    "UNSUPPORTED_PROTOCOL": "its TLS is older than 1.3",
    "NO_SHARED_CIPHER": "its TLS is older than 1.3",
    "PEER_DID_NOT_RETURN_A_CERTIFICATE": "it has shown no certificate",
    "CERTIFICATE_VERIFY_FAILED": "its certificate is not by our certificate authority",
    "TLSV13_ALERT_CERTIFICATE_REQUIRED": "it wants a certificate of us: give keys=FOLDER",
    "TLSV1_ALERT_UNKNOWN_CA": "our certificate is not by its certificate authority",
    "TLSV1_ALERT_PROTOCOL_VERSION": "it speaks another version of TLS",
}
# OpenSSL's verify codes for a certificate of our own authority
_VERIFY = {
    9: "it is not valid yet: is the clock right?",
    10: "it has expired: is the clock right?",
    26: "it is for the other end: a boat needs a boat's, the vehicle the vehicle's",
}


def tune(connected: socket.socket) -> None:
    """Send small frames at once, and find a peer whose radio is gone within half a minute."""
    connected.setblocking(False)
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    idle, interval, probes = KEEPALIVE
    for option, value in (
        ("TCP_KEEPIDLE", idle),
        ("TCP_KEEPINTVL", interval),
        ("TCP_KEEPCNT", probes),
        ("TCP_USER_TIMEOUT", GIVEN_UP),
    ):
        if hasattr(socket, option):  # Linux; elsewhere the system's own timeouts
            connected.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)


def in_words(error: OSError) -> str:
    if isinstance(error, ssl.SSLCertVerificationError):
        if error.verify_code in _VERIFY:
            return f"its certificate is refused: {_VERIFY[error.verify_code]}"
        return f"{_REASONS['CERTIFICATE_VERIFY_FAILED']} ({error.verify_message})"
    if isinstance(error, ssl.SSLError):
        return _REASONS.get(error.reason or "", (error.reason or str(error)).lower())
    if isinstance(error, TimeoutError):
        return "it does not speak TLS, or not in time"
    return error.strerror or str(error)


class Stream:
    """One connection. ``came``: when it connected. ``heard``: when its last byte came. ``proved``:
    whether it has proved itself, by a certificate or a valid frame (``TcpServer.vouch``)."""

    __slots__ = (
        "address", "came", "ended", "established", "heard", "host", "proved", "socket", "waiting",
        "why",
    )  # fmt: skip

    def __init__(
        self, connected: socket.socket, address: str, host: str = "", now: float = 0.0
    ) -> None:
        self.socket, self.address, self.host = connected, address, host
        self.came = self.heard = now
        self.proved = False
        self.waiting = bytearray()
        self.established = not isinstance(connected, ssl.SSLSocket)
        self.ended, self.why = False, ""

    def handshake(self) -> None:
        """Continue the TLS handshake as far as possible without blocking."""
        assert isinstance(self.socket, ssl.SSLSocket)
        try:
            self.socket.do_handshake()
        except _AGAIN:
            return
        except (OSError, ValueError) as error:
            self._end(error)
            return
        self.established = self.proved = True

    @property
    def is_viewer(self) -> bool:
        """Whether its certificate is a viewer's, who may look but not command."""
        shown = self.socket.getpeercert() if isinstance(self.socket, ssl.SSLSocket) else None
        named = (shown or {}).get("subject", ())
        return any((ROLE, VIEWER) in row for row in named)

    def read(self) -> bytes:
        """Return the bytes that have come. Sets ``ended`` when the other side is gone."""
        out = bytearray()
        while not out or (isinstance(self.socket, ssl.SSLSocket) and self.socket.pending()):
            try:
                data = self.socket.recv(READ)
            except _AGAIN:
                break
            except OSError as error:
                self._end(error)
                break
            if not data:
                self.ended = True
                break
            out += data
        return bytes(out)

    def write(self, data: bytes = b"") -> None:
        self.waiting += data
        while self.waiting and not self.ended:
            try:
                sent = self.socket.send(self.waiting)
            except _AGAIN:
                break
            except OSError as error:
                self._end(error)
                break
            del self.waiting[:sent]
        if len(self.waiting) > BACKLOG:
            self.ended, self.why = True, "it does not read what it is sent"

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self.socket.close()

    def _end(self, error: OSError | ValueError) -> None:
        self.ended = True
        gone = isinstance(error, (ConnectionError, ssl.SSLEOFError, ssl.SSLZeroReturnError))
        self.why = in_words(error) if isinstance(error, OSError) and not gone else ""
