"""The examples of documents 002, 003 and 004, each with the link that carries it."""

from __future__ import annotations

from protocol.examples import examples
from protocol.vehicles.motorcan import from_line

_LINKS = {
    "coreboard.MAIN_TO_PC": "coreboard.main_to_pc",
    "coreboard.PC_TO_MAIN": "coreboard.pc_to_main",
    "coreboard.MAIN_TO_SENSOR": "coreboard.main_to_sensor",
    "coreboard.SENSOR_TO_MAIN": "coreboard.sensor_to_main",
    "rov.UP": "rov.up",
    "rov.DOWN": "rov.down",
    "robot.DOWN": "robot.down",
    "robot.UP": "robot.up",
}

# type, the link that carries it, the frame
OTHERS = [
    *((e.type, _LINKS[e.type], e.raw) for e in examples() if e.type in _LINKS),
    ("coreboard.CAN_FORCE", "coreboard.can", from_line("001#FF001000200030")),
    ("coreboard.CAN_TORQUE", "coreboard.can", from_line("002#FE001000200030")),
]
