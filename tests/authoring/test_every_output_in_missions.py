"""Every output that a board can have, in a mission: what a limit, the proof of the surface or the
operator's way needs is set by none, whatever the vehicle file calls it; nor is what is final."""

from __future__ import annotations

from dataclasses import replace

import pytest
from every_output import with_every_output

from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import MissionErrors, digest, parse
from protocol.vehicles import VEHICLES
from protocol.vehicles.channels import Channel

NEEDED = {  # by codec: as the documents name them, not as the tables of the program do
    "auv": {f"power_{name}" for name in ("ctd", "altimeter", "bdgps", "uacm", "radio")},
    "coreboard": {"ins_on", "dvl_on", "nav"},
    "mainboard": {f"{name}_on" for name in ("ins", "dvl", "modem", "altimeter", "depth", "ctd")},
    "rov": set(),
    "robot": set(),
}
FINAL = {"mainboard": {"drop_weight"}}
CASES = [(row.name, channel) for row in VEHICLES.values() for channel in row.channels]
TEXT = "mission m vehicle {}\nstart without fix\nassume current 0\na: stop output it {} for 5s\n"


@pytest.mark.parametrize(("name", "channel"), CASES, ids=lambda v: getattr(v, "name", v))
def test_a_mission_sets_an_output_unless_something_needs_it_or_it_is_final(
    name: str, channel: Channel
) -> None:
    vehicle = with_every_output(name)
    outputs = tuple(
        replace(output, name="it") for output in vehicle.outputs if output.channel == channel.name
    )
    for level in (channel.low, channel.high):
        mission = parse(TEXT.format(name, f"{level:g}"))
        try:
            compile_mission(mission, replace(vehicle, outputs=outputs), digest(mission))
            found = set()
        except MissionErrors as errors:
            found = {diagnostic.code for diagnostic in errors.diagnostics}
        if channel.name in NEEDED[name]:
            assert "needed-output" in found
        elif channel.name in FINAL.get(name, ()):
            assert "irreversible" in found
        else:
            assert not found


def test_what_is_needed_is_there() -> None:
    for name, needed in (*NEEDED.items(), *FINAL.items()):
        assert needed <= {channel.name for channel in VEHICLES[name].channels}
