"""What the frames of a board of documents 002 to 004 mean, in the words that the laws read.

    what X says        @ZAX0$        full thrust upward    @ZAU12$        downward    @ZAD12$

The boards repeat one frame instead of acknowledging words, and W is the bytes of upward thrust.
Only what moves is compared; of the robot, nothing is upward.

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

Motion = Mapping[str, Any]  # what of a frame moves; empty: nothing does
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
_NEAR, _NEAR_G = 0.1, 10.0  # deg, m, shares, N m; gram-force: a Step rounds what it says


class Speech:
    """Raises KeyError for a vehicle whose frames are none of these."""

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
        """Of each frame that says it; none where there is none."""
        try:
            return [self.motion(frame) for frame in self.board.encode(command)]
        except CannotEncode:
            return []

    def motion(self, data: bytes) -> Motion:
        """Empty: it is an output's own word."""
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
        """The word of the laws that it is; "" if it is none of them, or a part of several, as no
        torque is."""
        said = self.motion(data)
        found = [word for word, meant in self.words.items() if said and same(meant, said)]
        return found[0] if len(found) == 1 else b""

    def steers(self, word: bytes) -> bool:
        """Whether it has frames for this M."""
        try:
            return bool(self.board.stick(Setpoint(), word))
        except CannotEncode:
            return False


def same(asked: list[Motion], said: Motion) -> bool:
    """Whether it is one of those; numbers may differ by what rounding makes of them."""
    return any(one.keys() == said.keys() and _near(one, said) for one in asked)


def _near(a: Motion, b: Motion) -> bool:
    return all(abs(_off(n, a, b)) <= (_NEAR_G if n.endswith("_g") else _NEAR) for n in a)


def _off(name: str, a: Motion, b: Motion) -> float:
    return math.remainder(a[name] - b[name], 360.0) if name in _ROUND else a[name] - b[name]
