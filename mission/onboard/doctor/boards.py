"""The boards of the four documents, for advice to a person: their names, why they may be silent,
and what they do without commands.

What does not live here: the findings (port_probe, doctor), frames and times (protocol.vehicles).
"""

from __future__ import annotations

from dataclasses import dataclass

from mission.model.vehicle import Vehicle
from protocol.vehicles import coreboard, motorcan, robot, rov


@dataclass(frozen=True, slots=True)
class Board:
    """``quiet``: why the board may be silent without a fault, "" if nothing explains it.
    ``switch``: how a sensor gets its power. ``silence``: s without a command after which the board
    goes neutral by itself; None: never. ``beside``: what works without Pi and board. ``moves``:
    what the board drives."""

    name: str
    quiet: str
    switch: str
    silence: float | None
    beside: str
    reports: bool = True
    moves: str = "the thrusters"


BOARDS = {
    "auv": Board(
        "the STM32",
        "in manual it sends no @SD",
        "auvmission power",
        None,
        "a rope or a drop weight",
    ),
    "coreboard": Board(
        "the core board",
        "",
        "a frame of serve switches its INS on (byte 43): look again with serve running",
        coreboard.SILENCE,
        "a rope or a drop weight",
    ),
    "motorcan": Board(
        "the motor boards",
        "they report nothing",
        "they have no sensors",
        motorcan.SILENCE,
        "a rope or a drop weight",
        reports=False,
    ),
    "mainboard": Board(
        "the sensor board",
        "",
        "a frame of serve switches it on: look again with serve running",
        motorcan.SILENCE,
        "a rope or a drop weight",
    ),
    "rov": Board("the ROV's board", "", "it has no switch for it", rov.SILENCE, "its tether"),
    "robot": Board(
        "the robot's board",
        "",
        "it has no switch for it",
        robot.SILENCE,
        "its power switch at hand",
        moves="the wheels",
    ),
}


def board(vehicle: Vehicle) -> Board:
    """The vehicle's board; for one that is not in the table, texts that are true of any."""
    own = BOARDS.get(vehicle.codec)
    name = f"the board of {vehicle.name}"
    return own or Board(name, "", "look it up in its document", None, "a rope or a drop weight")


def trip(vehicle: Vehicle) -> str:
    return "drive" if vehicle.drives else "dive"


def at_rest(vehicle: Vehicle) -> str:
    """Where the vehicle has to be when serve is restarted, as text."""
    return "standing still" if vehicle.drives else "at the surface"
