"""The AUV's channels (document 000): rudders by ``@DS``, power by ``@RS``; its sources.

``@RS`` switches all seven devices at once. To switch one, the others are sent as this module sent
them last, at first as on. CTD and radio stay on in any case (E-T2); in one build of the firmware
some letters mean other devices.

What does not live here: the frames (protocol.topside_frames), the report (protocol.vehicles.auv).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from protocol.messages import Telemetry
from protocol.topside_frames import RS, SENSORS, D
from protocol.vehicles.channels import Channel, Source

_UP, _DOWN = 22, -15  # deg
_RUDDERS = {"rudder_left_deg": 1, "rudder_right_deg": 2}
_NEEDED = {
    "CTD": "the depth, and with it the limit of depth, comes from it",
    "altimeter": "what contradicts a wrong depth comes from it",
    "BDGPS": "the proof of the surface comes from it",
    "UACM": "it is the operator's way to the vehicle",
    "radio": "it is the operator's way to the vehicle",
}
POWER = tuple(f"power_{name.lower()}" for name in SENSORS)
CHANNELS: tuple[Channel, ...] = (
    *(Channel(name, "deg", _DOWN, _UP, "rudder, up positive") for name in _RUDDERS),
    *(
        Channel(name, "", 0, 1, f"power of the {device}", 1, needed=_NEEDED.get(device, ""))
        for name, device in zip(POWER, SENSORS, strict=True)
    ),
)


def frames_of(given: Mapping[str, float], levels: Mapping[str, float]) -> dict[str, bytes]:
    """Return the frames for the channels ``given``, by what they set. ``levels`` has all."""
    frames = {
        name: D.encode({"mode": "S", "servo": servo, "angle": int(given[name])})
        for name, servo in _RUDDERS.items()
        if name in given
    }
    if any(name in given for name in POWER):
        switches = "".join("O" if levels[name] else "C" for name in POWER)
        frames["power"] = RS.encode({"switches": switches})
    return frames


def _magnetic(index: int) -> Callable[[Telemetry], float | None]:
    def read(report: Telemetry) -> float | None:
        tesla = report.magnetic
        return None if tesla is None or index >= len(tesla) else round(1e6 * tesla[index], 9)

    return read


SOURCES: tuple[Source, ...] = (
    *(
        Source(f"mag_{place}_{axis}", "uT", f"magnetometer, {place}, {axis}", _magnetic(3 * i + j))
        for i, place in enumerate(("front", "left", "right"))
        for j, axis in enumerate("xyz")
    ),
    Source("temperature_c", "C", "of the water", lambda report: report.temperature_c),
)
