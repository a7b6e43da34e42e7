"""Disturbances of a rig: each is one act at one time.

What does not live here: which disturbances are drawn (campaign.disturbances), how the rig carries
them out (rig).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

TOPSIDE, MODEM, PORT = "topside", "modem", "vehicle"
BOAT, OTHER_BOAT = "boat", "other boat"


class Act(enum.Enum):
    SAY = "says"
    JOIN = "connects"
    PART = "loses its connection"
    KILL = "the program is killed"
    BOOT = "the program begins anew"
    LEAVE = "the program has ended by itself"
    END = "the program is told to end, and begins anew when it has"
    HURRY = "the program is told to end at once"
    UNPLUG = "the cable to the STM32 is pulled"
    PLUG = "the cable to the STM32 is back"
    FILL = "the disk is full"
    FREE = "the disk has room again"
    STALL = "the program stands still"
    RUN = "the program goes on"
    POWER = "Pi and STM32 are without power"
    DIE_BEFORE = "the program will be killed before its next write"
    DIE_AFTER = "the program will be killed after its next write"


@dataclass(frozen=True, slots=True)
class Disturbance:
    after: float
    act: Act
    data: bytes = b""
    link: str = TOPSIDE
    address: str = BOAT
