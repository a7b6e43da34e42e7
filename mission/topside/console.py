"""The sockets around a conversation with a Pi: connects, waits, and reports failures in words.

    Unreachable        (the operator must act: nobody listens, the connection broke)
    Occupied           (another program has the port)
    BrokenOff          (something else must be sent first)

What does not live here: what is sent (upload). Reads the monotonic clock, for its own waiting.
"""

from __future__ import annotations

import select
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from links import open_link
from links.base import Link, LinkBusy, LinkError, Rx
from mission.topside.monitor import Frame, Watched
from mission.topside.underwater import BatchTalk, Submerged, modem_address
from mission.topside.upload import Conversation, OperatorError, Script
from mission.topside.upload import upload as upload_script

NAME = "vehicle"
LOOK_S = 0.02
BREAK_S = 0.2  # time in which a conversation breaks off
HANDSHAKE_S = 60  # handshake of a monitor: as long as it allows its viewers


class Unreachable(OperatorError):
    pass


class Occupied(Unreachable):
    pass


class BrokenOff(OperatorError):
    def __init__(self) -> None:
        super().__init__("broken off by something else that is said")


def _never() -> bool:
    return False


class Talk(Protocol):
    """The interface of a conversation that ``hold`` needs, over any medium."""

    @property
    def over(self) -> bool: ...
    @property
    def result(self) -> str | None: ...
    @property
    def failure(self) -> OperatorError | None: ...

    def begin(self, now: float) -> list[bytes]: ...
    def next_timer(self) -> float | None: ...
    def handle_timer(self, now: float) -> list[bytes]: ...
    def receive(self, data: bytes, now: float) -> list[bytes]: ...


def converse(url: str, script: Script, broken: Callable[[], bool] = _never) -> str:
    """Run a script and return its result. ``broken``: whether to break off. Raises
    OperatorError."""
    modem = modem_address(url)
    if modem is not None:
        return hold(modem.link, Submerged(script, modem.acoustics), broken)
    return hold(url, Conversation(script), broken)


def upload(
    url: str, lines: Sequence[str], digest: str, progress: Callable[[int, int], None]
) -> str:
    """Upload line by line, or in batches through a modem. Raises OperatorError."""
    modem = modem_address(url)
    if modem is not None:
        return hold(modem.link, BatchTalk(lines, digest, modem.acoustics, progress))
    return hold(url, Conversation(upload_script(lines, digest, progress)))


def hold(url: str, talk: Talk, broken: Callable[[], bool] = _never) -> str:
    """Hold a conversation over the link of this URL. Raises OperatorError."""
    try:
        link = open_link(NAME, url)
    except LinkBusy as error:
        raise Occupied(str(error)) from error
    except LinkError as error:
        raise Unreachable(str(error)) from error
    try:
        out = talk.begin(time.monotonic())
        while not talk.over:
            if broken():
                raise BrokenOff
            for frame in out:
                link.send(frame, time.monotonic())
            due = talk.next_timer()
            wait = 0.05 if due is None else max(0.0, due - time.monotonic())
            select.select([link.fileno()], [], [], min(wait, BREAK_S))
            now = time.monotonic()
            out = [f for rx in link.receive(now) for f in talk.receive(rx.data, now)]
            out = out or talk.handle_timer(now)
    except LinkError as error:
        raise Unreachable(f"{error}; what was asked last may or may not have been done") from error
    finally:
        link.close()
    if talk.failure is not None:
        raise talk.failure
    return talk.result or ""


def overhear(url: str) -> Iterator[Rx]:
    """Yield what the link receives, without end; b"" after every ``LOOK_S`` without any. ``t`` is
    in s since 1970 UTC, and does not jump with the clock. Raises LinkError."""
    link = open_link("port", url)
    zero = time.time() - time.monotonic()
    try:
        while True:
            watched = [link.fileno()] if link.fileno() >= 0 else []
            select.select(watched, [], [], LOOK_S)
            yield from _heard(link, zero + time.monotonic())
    finally:
        link.close()


def speak(url: str, data: bytes, repeat: tuple[float, float], answers: float) -> Iterator[Rx]:
    """Send the bytes, again every ``repeat[0]`` s for ``repeat[1]`` s, and yield what is received
    until ``answers`` s later. Times as in ``overhear``. Raises LinkError."""
    every, seconds = repeat
    link = open_link("port", url)
    begun = due = time.monotonic()
    zero = time.time() - begun
    try:
        while (now := time.monotonic()) <= begun + seconds + max(answers, LOOK_S):
            if due <= now and due <= begun + seconds:
                link.send(data, now)
                due += every
            select.select([link.fileno()] if link.fileno() >= 0 else [], [], [], LOOK_S)
            yield from _heard(link, zero + time.monotonic())
    finally:
        link.close()


def _heard(link: Link, now: float) -> Iterator[Rx]:
    yield from (rx._replace(link="") for rx in link.receive(now) or [Rx(now, "", b"")])


def patient(url: str) -> str:
    """Give the handshake as much time as the monitor allows: a slow radio needs half a minute."""
    if not url.startswith("tls://") or "handshake=" in url:
        return url
    return f"{url}{'&' if '?' in url else '?'}handshake={HANDSHAKE_S}"


def observe(url: str, wish: bytes, watched: Watched) -> Iterator[Frame | None]:
    """Yield the frames of a monitor, without end, and answer each; None after every ``LOOK_S``
    without a frame. Raises LinkError, NoMonitor."""
    link = open_link("monitor", patient(url))
    try:
        link.send(wish, time.monotonic())
        while True:
            select.select([link.fileno()], [], [], LOOK_S)
            now, frames = time.monotonic(), list[Frame | None]()
            for rx in link.receive(now):
                came, answers = watched.receive(rx.data, now)
                frames += came
                if answers:
                    link.send(answers, now)
            yield from frames or [None]
    finally:
        link.close()
