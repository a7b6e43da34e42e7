"""A joystick of the Linux kernel, /dev/input/js*, as a hand on a stick. Sans-IO.

    event: u32 time | i16 value | u8 type (1 button, 2 axis; + 0x80: as it was at the opening) |
           u8 number            (linux/joystick.h)

The dead man is a button that must be held. If it was held before the pad was opened, it counts only
when it is pressed again. A pad that sends nothing for ``SILENT_S`` counts as lost: a wireless one
out of reach keeps its last values.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from mission.topside.helm import Push

SILENT_S = 10.0
DEAD_ZONE = 0.1
_EVENT = struct.Struct("=IhBB")
_BUTTON, _AXIS, _INITIAL = 1, 2, 0x80
_FULL = 32767.0


@dataclass(frozen=True, slots=True)
class Layout:
    """Numbers of the axes and of the dead man's button, as `jstest` shows them. Ahead and up are
    negative values."""

    turn: int = 0
    surge: int = 1
    heave: int = 4
    dead_man: int = 4


class Joystick:
    """``share``: the share of full thrust at full deflection."""

    def __init__(self, layout: Layout, share: float) -> None:
        self._layout, self._share = layout, share
        self._axes: dict[int, float] = {}
        self._held, self._heard = False, 0.0
        self._rest = b""

    def receive(self, data: bytes, now: float) -> None:
        whole = self._rest + data
        end = len(whole) - len(whole) % _EVENT.size
        self._rest = whole[end:]
        for _, value, kind, number in _EVENT.iter_unpack(whole[:end]):
            self._heard = now
            if kind & ~_INITIAL == _AXIS:
                self._axes[number] = value / _FULL
            elif number == self._layout.dead_man:
                self._held = kind == _BUTTON and value != 0

    def push(self, now: float) -> Push | None:
        if not self._held or now - self._heard > SILENT_S:
            self._held = False
            return None
        axes, layout = self._axes, self._layout
        ahead, aside, up = (
            sign * axes.get(number, 0.0)
            for sign, number in ((-1, layout.surge), (1, layout.turn), (-1, layout.heave))
        )
        return Push(self._scaled(ahead), self._scaled(aside), self._scaled(up))

    def _scaled(self, value: float) -> float:
        return 0.0 if abs(value) <= DEAD_ZONE else self._share * max(-1.0, min(1.0, value))
