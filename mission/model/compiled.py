"""Which modules mypyc may compile, and which of them are compiled where this program runs.

Compiled code comes from the same sources and gives the same bytes, but faster. The list has the
modules in which an hour of flight spends its time, and those of a campaign's laws. Not compiled:
classes that others inherit from (frames, codecs), and code that runs once per flight.

What does not live here: how they are compiled (hatch_build.py).
"""

from __future__ import annotations

from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import mission

MODULES = (
    "links.simulated.boards",
    "links.simulated.faults",
    "links.simulated.firmware.as_built",
    "links.simulated.firmware.controllers",
    "links.simulated.firmware.documented",
    "links.simulated.firmware.gps",
    "links.simulated.firmware.manual",
    "links.simulated.firmware.stm32",
    "links.simulated.firmware.uart",
    "links.simulated.geodesy",
    "links.simulated.ground",
    "links.simulated.link",
    "links.simulated.plant",
    "links.simulated.schedule",
    "links.simulated.sea",
    "links.simulated.sensors",
    "links.simulated.settings",
    "links.simulated.waves",
    "links.simulated.wrong",
    "mission.analysis.smoothing",
    "mission.engine.ascent",
    "mission.engine.attitude",
    "mission.engine.auxiliary",
    "mission.engine.bounds",
    "mission.engine.clearance",
    "mission.engine.core",
    "mission.engine.engine",
    "mission.engine.flying",
    "mission.engine.guards",
    "mission.engine.lasting",
    "mission.engine.limits",
    "mission.engine.memory",
    "mission.engine.monitor",
    "mission.engine.outputs",
    "mission.engine.readings",
    "mission.engine.rest",
    "mission.engine.restart",
    "mission.engine.run",
    "mission.engine.state",
    "mission.engine.thrust",
    "mission.engine.variables",
    "mission.engine.vehicle_state",
    "mission.engine.watch",
    "mission.engine.words",
    "mission.model.vehicle",
    "mission.navigation.belief",
    "mission.navigation.distribution",
    "mission.navigation.filter",
    "mission.navigation.fixes",
    "mission.navigation.health",
    "mission.navigation.model",
    "mission.navigation.navigator",
    "mission.navigation.reckoner",
    "mission.onboard.runtime.device_switches",
    "mission.onboard.runtime.frontseat",
    "mission.onboard.runtime.operator_channels",
    "mission.onboard.runtime.operator_server",
    "mission.onboard.runtime.receivers",
    "mission.onboard.runtime.relays",
    "mission.onboard.runtime.restated",
    "mission.onboard.runtime.resume_marker",
    "mission.onboard.runtime.runtime",
    "mission.onboard.runtime.situation",
    "mission.verification.campaign.audit",
    "mission.verification.campaign.excuses",
    "mission.verification.campaign.laws",
    "mission.verification.campaign.leg_laws",
    "mission.verification.campaign.permits",
    "mission.verification.campaign.reports",
    "mission.verification.campaign.story",
    "mission.verification.campaign.trial",
    "mission.verification.rig.lockstep",
    "mission.verification.rig.program",
    "mission.verification.rig.rehearsal",
    "mission.verification.rig.rig",
    "mission.verification.rig.trace",
    "mission.verification.simulation.flight",
    "mission.verification.simulation.flightlog",
    "protocol.checksum",
    "protocol.framing",
    "protocol.nmea",
    "protocol.nmea_fields",
    "protocol.starts",
    "protocol.topside",
    "protocol.vehicles.sd_stream",
)
_ROOT = Path(mission.__file__).resolve().parents[1]


def compiled() -> list[str]:
    """Return those MODULES that have a compiled form beside their source; Python prefers it."""
    return [name for name in MODULES if any(map(Path.exists, _extensions(name)))]


def build() -> str:
    """In words: ``pure Python``, or how many modules are compiled."""
    there = compiled()
    return f"{len(there)} of {len(MODULES)} modules compiled" if there else "pure Python"


def _extensions(name: str) -> list[Path]:
    path = _ROOT.joinpath(*name.split("."))
    return [path.with_name(path.name + suffix) for suffix in EXTENSION_SUFFIXES]
