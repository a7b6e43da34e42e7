"""Translate the frames of the boards of documents 002 to 004 into the commands that laws read.

    stop    @ZAX0$        full thrust upward    @ZAU12$        full thrust downward    @ZAD12$

The boards repeat one frame instead of acknowledging commands, and W has the bytes of upward thrust.
Only the fields that move the vehicle are compared. The robot has no upward motion.

What does not live here: the laws (audit of boards, depth_laws, word_laws), the frames (protocol).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mission.engine.ascent import DOWNWARD
from mission.model.vehicle import Vehicle
from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import UPWARD, Order, Setpoint
from protocol.tolerances import Tolerances
from protocol.vehicles import codec, link
from protocol.vehicles.adapter import SilentBoard
from protocol.vehicles.robot_outputs import HANDSHAKE, ROBOT

Motion = Mapping[str, Any]  # the fields of a frame that move the vehicle; empty: none does
WORDS: Mapping[bytes, Setpoint | Order] = {
    b"@ZAX0$": Order.STOP,
    b"@ZAU12$": UPWARD,
    b"@ZAD12$": DOWNWARD,
}
_SIX = ("tx", "ty", "tz", "mx", "my", "mz")
MOTION: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "coreboard": ("coreboard.pc_to_main", (*_SIX, "closed_loop", "depth_m", "heading_deg")),
    "rov": ("rov.down", ("x", "z", "f", "hold_heading", "hold_depth")),
    "robot": ("robot.down", ("command", "speed_mm_s")),
    "mainboard": ("coreboard.can", ("fx_g", "fy_g", "fz_g", "mx_nm", "my_nm", "mz_nm")),
}
_ROUND = frozenset({"heading_deg"})  # 180 and -180 are the same
_NEAR, _NEAR_G = 0.1, 10.0  # deg, m, shares, N m; gram-force: a Step rounds its values


class Speech:
    """What the frames of one vehicle mean. Raises KeyError for a vehicle that MOTION lacks."""

    def __init__(self, vehicle: Vehicle) -> None:
        row, self._moves = MOTION[vehicle.codec]
        made = codec(*vehicle.speaks)
        assert isinstance(made, SilentBoard)
        self.board = made
        self._link, self._tolerances = link(row), Tolerances.parse(vehicle.tolerances)
        self._known: dict[bytes, Motion] = {}
        self.words = {word: self.motions(command) for word, command in WORDS.items()}
        self.lifts = bool(self.words[b"@ZAU12$"])

    def motions(self, command: Setpoint | Order) -> list[Motion]:
        """Return the motion of each frame of a command; none if the board has no frame for it."""
        try:
            return [self.motion(frame) for frame in self.board.encode(command)]
        except CannotEncode:
            return []

    def motion(self, data: bytes) -> Motion:
        """Return what a frame moves; empty for the own command of an output."""
        if data not in self._known:
            if len(self._known) > 5000:
                self._known.clear()
            self._known[data] = self._read(data)
        return self._known[data]

    def _read(self, data: bytes) -> Motion:
        for frame in self._link.framer(self._tolerances).receive(data, 0.0):
            assert isinstance(frame, Frame)
            values = frame.values()
            if values.get("address", ROBOT) == ROBOT and values.get("command") != HANDSHAKE:
                return {name: values[name] for name in self._moves if name in values}
        return {}

    def word(self, data: bytes) -> bytes:
        """Return the command in WORDS that this frame is. b"" if it is none, or may be a part of
        several, such as the frame of zero torque."""
        said = self.motion(data)
        found = [word for word, meant in self.words.items() if said and same(meant, said)]
        return found[0] if len(found) == 1 else b""

    def steers(self, word: bytes) -> bool:
        """Whether the board has frames for this M."""
        try:
            return bool(self.board.stick(Setpoint(), word))
        except CannotEncode:
            return False


def same(asked: list[Motion], said: Motion) -> bool:
    """Whether ``said`` is one of ``asked``; numbers may differ by rounding."""
    return any(one.keys() == said.keys() and _near(one, said) for one in asked)


def _near(a: Motion, b: Motion) -> bool:
    return all(abs(_off(n, a, b)) <= (_NEAR_G if n.endswith("_g") else _NEAR) for n in a)


def _off(name: str, a: Motion, b: Motion) -> float:
    return math.remainder(a[name] - b[name], 360.0) if name in _ROUND else a[name] - b[name]
