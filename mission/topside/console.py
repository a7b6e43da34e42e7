"""The socket shell around a conversation with a Pi: connects, waits, gives up in words.

    Unreachable        (the operator must act: nobody listens, the connection broke)

What does not live here: what is said (upload). Reads the monotonic clock, for its own waiting.
"""

from __future__ import annotations

import math
import select
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from links import open_link
from links.base import LinkError
from mission.topside.underwater import BatchTalk, Submerged, modem_address
from mission.topside.upload import Conversation, OperatorError, Script
from mission.topside.upload import upload as upload_script

NAME = "vehicle"


class Unreachable(OperatorError):
    pass


class Talk(Protocol):
    """What ``hold`` needs of a conversation, over whatever medium."""

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


def converse(url: str, script: Script) -> str:
    """What the script achieved. Raises OperatorError."""
    modem = modem_address(url)
    if modem is not None:
        return hold(modem.link, Submerged(script, modem.acoustics))
    return hold(url, Conversation(script))


def upload(
    url: str, lines: Sequence[str], digest: str, progress: Callable[[int, int], None]
) -> str:
    """Line by line, or in batches where a modem is between. Raises OperatorError."""
    modem = modem_address(url)
    if modem is not None:
        return hold(modem.link, BatchTalk(lines, digest, modem.acoustics, progress))
    return hold(url, Conversation(upload_script(lines, digest, progress)))


def hold(url: str, talk: Talk) -> str:
    """The conversation over the link of this URL. Raises OperatorError."""
    try:
        link = open_link(NAME, url)
    except LinkError as error:
        raise Unreachable(str(error)) from error
    try:
        out = talk.begin(time.monotonic())
        while not talk.over:
            for frame in out:
                link.send(frame, time.monotonic())
            due = talk.next_timer()
            wait = 0.05 if due is None else max(0.0, due - time.monotonic())
            select.select([link.fileno()], [], [], wait)
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


def degrees(angle: float | None, places: int) -> float | None:
    return None if angle is None else round(math.degrees(angle), places)
