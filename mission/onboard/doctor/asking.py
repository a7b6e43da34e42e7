"""Find out which dialect the AUV's board speaks: send it a stop, and read the acknowledgement.

    @ZAX0$ -->   @ACK_ZXY$   documented     @ACK_ZAY$   as built

Use this only on deck, and only if no serve has the port: any other Z would move something, and even
this one ends manual mode. What does not live here: listening to the reports (port_probe).
"""

from __future__ import annotations

import time

from links import open_link
from links.base import Link, LinkError
from mission.model.vehicle import Vehicle
from mission.onboard.doctor.findings import Finding, fault, ok, warning
from mission.onboard.doctor.port_probe import listened, not_open
from protocol.codec import VehicleCodec
from protocol.messages import Ack, Order
from protocol.vehicles import codec
from protocol.vehicles.auv import dialect_of

WHAT = "dialect"
ANSWER_S = 1.0  # s, longer than a whole @SD that comes first
TRIES = 3
_FILES = {"as-built": "auv", "documented": "auv-documented"}


def needless(vehicle: Vehicle) -> Finding | None:
    """The finding if this vehicle is not asked; None if it can be."""
    if vehicle.codec == "auv":
        return None
    return ok(WHAT, "not asked: this board answers nothing, and has one dialect")


def dialect_finding(url: str, vehicle: Vehicle) -> Finding:
    if (told := needless(vehicle)) is not None:
        return told
    try:
        link = open_link("vehicle", url)
    except LinkError as error:
        return not_open(WHAT, url, error)
    board = codec(*vehicle.speaks)
    try:
        for _ in range(TRIES):
            if spoken := _spoken(link, board):
                return _told(spoken, vehicle)
    except LinkError as error:
        return fault(WHAT, str(error), "check cable and plug, then run doctor again")
    finally:
        link.close()
    return warning(
        WHAT,
        f"no answer to @ZAX0$ in {TRIES} tries",
        "check the Pi's TX line to the STM32, and that node STM32 has power",
    )


def _spoken(link: Link, board: VehicleCodec) -> str:
    begun = time.monotonic()
    link.send(b"".join(board.encode(Order.STOP)), begun)
    for data, now in listened(link, lambda: time.monotonic() - begun >= ANSWER_S):
        for one in board.receive(data, now):
            if isinstance(one, Ack) and (spoken := dialect_of(one)):
                return spoken
    return ""


def _told(spoken: str, vehicle: Vehicle) -> Finding:
    if spoken == vehicle.dialect:
        return ok(WHAT, f"the board speaks {spoken}, as the vehicle file says")
    return fault(
        WHAT,
        f"the board speaks {spoken}, the vehicle file {vehicle.dialect}: a leg's first set would "
        "be refused or misread",
        f"write `vehicle: {_FILES[spoken]}` into the configuration, or `dialect: {spoken}` into "
        "your vehicle file",
    )
