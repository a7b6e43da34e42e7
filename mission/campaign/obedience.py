"""X and W are obeyed: each is on its way to the STM32 within 100 ms of being known (R7).

Looked at are those that came as a whole and alone, behind nothing that is no frame (G3), while
the program ran; one that a later order or the program's death overtook in time is excused.

What does not live here: who else asked for a byte (audit).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mission.campaign.deeds import Act
from mission.campaign.trial import Done, Event, Said
from mission.drive.drive import VEHICLE
from mission.model import Tx
from protocol.messages import Emergency, Order
from protocol.modem import Sender, wrap
from protocol.topside import encode

WITHIN = 0.1  # s from known to on its way
CLEAN = 3.0  # s after bytes that a frame may still hang in
_SAME = 1e-6  # s
_FRAMES = tuple(encode(Emergency(order)) for order in Order)
_ORDERS = {
    **{frame: frame for frame in _FRAMES},
    **{wrap(frame, Sender.TOPSIDE): frame for frame in _FRAMES},
}


@dataclass(frozen=True, slots=True)
class Ignored:
    t: float
    says: str


def ignored(events: Sequence[Event]) -> Iterator[Ignored]:
    """Orders that were said and did not leave in time."""
    waits: Said | None = None
    unclean: dict[tuple[str, str], float] = {}
    lives = True
    for event in events:
        if waits is not None and event.t > waits.t + WITHIN + _SAME:
            yield Ignored(waits.t, f"{waits.data!r} of {waits.address or waits.link}: nothing left")
            waits = None
        match event:
            case Said():
                peer = (event.link, event.address)
                clean = event.t >= unclean.get(peer, -CLEAN) + CLEAN
                if lives and clean and event.data in _ORDERS:
                    waits = event
                elif event.data not in _ORDERS and not _whole(event.data):
                    unclean[peer] = event.t
            case Done(act=Act.KILL | Act.STALL):
                waits = None
                lives = event.act is not Act.KILL and lives
            case Done(act=Act.BOOT):
                lives = True
            case Tx(link=link, data=data) if link == VEHICLE and waits is not None:
                if data == _ORDERS[waits.data]:
                    waits = None
            case _:
                pass


def _whole(data: bytes) -> bool:
    return data.startswith(b"@") and data.endswith(b"$") and data.isascii()
