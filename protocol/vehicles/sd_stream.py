"""The fast path for the STM32's line: reads flawless ``@SD`` and the noise between them in one go.

    |..@SD.........$@SD.........$...@SD.........$xx@AC    reading ends behind the third frame
     ^ at                                       ^ stop

The result is that of the frame's table (protocol.vehicles.auv: ``telemetry``), at a third of the
cost, and only if nothing is doubtful. The ordinary scan reads everything else: values that are
flagged, torn frames, noise in which a frame could begin, any other checksum.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from typing import TypeAlias

from protocol.checksum import stm32_checker
from protocol.framing import Stretch, fault
from protocol.messages import Telemetry

LENGTH = 86
_TURN = 2 * math.pi
_DEGREE = math.pi / 180
_NO_ECHO = ("altitude_m:nan",)
# The types that the layout unpacks: with them compiled code computes with plain floats.
# fmt: off
_Row: TypeAlias = tuple[
    bytes, float, float, float, float, float, float,
    float, float, float, float, float, float, float, float, float,
    int, int, int, int, int, int, int, int, int, bytes, bytes,
]
# fmt: on
_LEAST, _MOST = 900, 2100  # us: outside, a thruster's width is garbage and no PWM (1000..2000)
_THRUSTERS, _NEUTRAL = 5, 0.02  # thrusters are the first five widths; share of full thrust
_FRACTIONS = tuple((width - 1500) / 500 if width else 0.0 for width in range(3000))
_SHARES = tuple(
    share if _LEAST <= width <= _MOST or not width else None
    for width, share in enumerate(_FRACTIONS)
)


def fractions_of(widths: Sequence[int]) -> tuple[float, ...] | None:
    """Return widths, us, as shares of full thrust or travel; no pulse (0 us) is neutral. If a
    thruster's width is garbage it counts as neutral while another thruster is on; else the state
    of all is unknown: None."""
    garbage = [w and not _LEAST <= w <= _MOST for w in widths[:_THRUSTERS]]
    if not any(garbage):
        return tuple((width - 1500) / 500 if width else 0.0 for width in widths)
    left = [0 if bad else w for w, bad in zip(widths, garbage, strict=False)]
    told = fractions_of((*left, *widths[_THRUSTERS:]))
    return told if told and any(abs(share) > _NEUTRAL for share in told[:_THRUSTERS]) else None


def sd_reader(
    layout: struct.Struct, control_scale: float, power_scale: float
) -> Callable[[bytes, int, int, int, float], Stretch]:
    """Return a ``Shortcut.read``. ``layout``: that of the frame's table. Scales: volts per count
    of the batteries."""
    unpack: Callable[[bytes, int], _Row] = layout.unpack_from
    agrees = stm32_checker(80)
    made: Callable[[type[Telemetry], tuple[object, ...]], Telemetry] = tuple.__new__
    turn, degree = _TURN, _DEGREE
    fractions, shares = _FRACTIONS, _SHARES

    def read(data: bytes, at: int, last: int, base: int, t: float) -> Stretch:
        items: list[object] = []
        gaps, stop = 0, at
        while at <= last:
            # fmt: off
            (head, roll, pitch, yaw, temperature, depth, altitude,
             fx, fy, fz, lx, ly, lz, rx, ry, rz,
             p1, p2, p3, p4, p5, p6, p7, control, power, crc, tail) = unpack(data, at)
            # fmt: on
            if head != b"@SD" or tail != b"$" or not agrees(data[at + 3 : at + 81] + b"\0\0", crc):
                break
            finite = temperature + depth
            if not (  # float constants: comparing with integers takes twice as long
                -90.0 <= roll <= 90.0
                and -180.0 <= pitch <= 180.0
                and -180.0 <= yaw <= 180.0
                and fx * fx + fy * fy + fz * fz <= 1e4  # then each axis is within 100 uT
                and lx * lx + ly * ly + lz * lz <= 1e4
                and rx * rx + ry * ry + rz * rz <= 1e4
                and finite - finite == 0.0
                and (altitude - altitude == 0.0 or altitude != altitude)  # not infinite
            ):
                break
            try:
                # fmt: off
                actuators = (shares[p1], shares[p2], shares[p3], shares[p4], shares[p5],
                             fractions[p6], fractions[p7])
                # fmt: on
            except IndexError:
                break
            if None in actuators:
                break
            echo = altitude == altitude  # NaN: no echo, perhaps in every second frame
            # fmt: off
            magnetic = (fx * 1e-6, fy * 1e-6, fz * 1e-6, lx * 1e-6, ly * 1e-6, lz * 1e-6,
                        rx * 1e-6, ry * 1e-6, rz * 1e-6)
            report = made(Telemetry, (
                t, depth, altitude if echo else None, -(yaw * degree) % turn, pitch * degree,
                roll * degree, temperature, magnetic,
                actuators,
                (control * control_scale, power * power_scale),
                None, None, None, () if echo else _NO_ECHO, (),
            ))
            # fmt: on
            if at != stop:
                items.append(fault(base + stop, "bad_header", at - stop))
                gaps += 1
            items.append(report)
            at = stop = at + LENGTH
            if at <= last and data[at] != 0x40:
                at = data.find(b"@", at)
                if at < 0:
                    break
        return items, gaps, stop

    return read
