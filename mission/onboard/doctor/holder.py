"""Find the link of a running serve that a URL names: two programs on one port would each get half
of its bytes.

What does not live here: the lock on a serial port (links.serial), which a serve with another folder
holds all the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from links import parse_address
from links.base import LinkError
from mission.onboard.configuration import Configuration
from mission.onboard.serve import health
from mission.onboard.serve.listening import listening


@dataclass(frozen=True, slots=True)
class Holder:
    """``link``: its name in serve's configuration; ``box``: the black box, None if unknown;
    ``is_joined``: the link joins a CAN bus and a serial line."""

    process: int
    link: str
    box: Path | None
    is_joined: bool = False


def holder(url: str, configuration: Configuration, wall: float) -> Holder | None:
    """Find who has the port; None if no serve with the configuration's folder has it."""
    running = health.read(configuration.folder, wall)
    if running is not None:
        urls = {name: link["url"] for name, link in running["links"].items()}
        box = Path(running["black_box"]) if running["black_box"] else None
        process = int(running["pid"])
    else:
        mute = health.mute(configuration.folder, wall)
        if mute is None:
            return None
        links = configuration.links
        urls = {"vehicle": links.vehicle, "gps": links.gps, "modem": links.modem}
        urls |= {"topside": listening(links.topside), "sensors": links.sensors, "gps2": links.gps2}
        box, process = None, mute
    for name, theirs in urls.items():
        if theirs is not None and _places(theirs) & _places(url):
            return Holder(process, name, box, len(_places(theirs)) > 1)
    return None


def _places(url: str) -> set[tuple[object, ...]]:
    """The devices or addresses of a URL, without its other options; symbolic links are resolved."""
    try:
        address = parse_address(url)
    except LinkError:
        return {(url,)}
    if address.scheme == "serial":
        return {(Path(address.path).resolve(),)}
    bus = (address.scheme, address.host, address.port, address.path)
    line = address.options.get("sensors")
    return {bus} if line is None else {bus, (Path(line).resolve(),)}
