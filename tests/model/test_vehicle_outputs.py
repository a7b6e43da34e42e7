"""The tables ``outputs`` and ``readings`` of a vehicle file: what is wrong is told where it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from mission.model.shipped import load_vehicle
from mission.model.vehicle import VehicleError
from mission.model.vehicle_file import read_vehicle
from protocol.vehicles import VEHICLES

ROV = Path("missions/vehicles/rov.yaml").read_text(encoding="utf-8")
HEAD = ROV[: ROV.index("outputs:")] + ROV[ROV.index("limits:") :]


def told(tables: str) -> str:
    with pytest.raises(VehicleError) as caught:
        read_vehicle(HEAD + tables, "rov.yaml")
    return str(caught.value)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("lamp: {safe: 0}", "no channel of that name [output]"),
        ("lamp: {channel: beam}", "rov has: led_pct, servo_deg"),
        ("lamp: {channel: led_pct, high: 101}", "high 101 is outside 0 to 100"),
        ("lamp: {channel: led_pct, high: 9.5}", "high 9.5 is not a whole number"),
        ("lamp: {channel: led_pct, low: 50, high: 40, safe: 45}", "low 50 is above high 40"),
        ("lamp: {channel: led_pct, low: 10}", "safe: lamp 0 is outside 10 to 100 %"),
        ("lamp: {channel: led_pct, colour: 3}", "no key colour"),
        ("lamp: {channel: led_pct, ascent: 1}", "ascent is for what is irreversible"),
        ("la-mp: {channel: led_pct}", "la-mp is no name"),
        ("a: {channel: led_pct}\n  b: {channel: led_pct}", "a has this channel already"),
    ],
)
def test_an_output_that_cannot_be_is_refused_with_its_line(line: str, why: str) -> None:
    found = told(f"outputs:\n  {line}\n")
    assert why in found
    number = HEAD.count("\n") + 2 + line.count("\n")
    assert found.startswith(f"rov.yaml:{number}:")


def test_what_a_document_does_not_tell_has_to_be_said() -> None:
    robot = Path("missions/vehicles/robot.yaml").read_text(encoding="utf-8")
    text = robot.replace("outputs:", "outputs:\n  limit: {channel: max_current_a}", 1)
    with pytest.raises(VehicleError, match="say what it is in an emergency"):
        read_vehicle(text, "robot.yaml")


def test_a_side_move_that_has_no_place_in_its_frame_is_refused_by_the_check() -> None:
    robot = Path("missions/vehicles/robot.yaml").read_text(encoding="utf-8")
    text = robot.replace("full_speed: 1000", "full_speed: 1000, speed_step: 0.1", 1)
    fast = text.replace("side_speed_mm_s, high: 500", "side_speed_mm_s, high: 4000", 1)
    assert read_vehicle(text, "robot.yaml").output("side_speed") is not None
    with pytest.raises(VehicleError, match="speed_mm_s: 40000 is outside"):
        read_vehicle(fast, "robot.yaml")


def test_a_reading_that_no_report_has_is_refused() -> None:
    found = told("readings: {phase: usbl1}\n")
    assert "rov reports no usbl1" in found
    assert "it reports: metal_pct" in found


def test_the_older_layout_of_the_rov_has_no_lamp() -> None:
    legacy = HEAD.replace("tolerances: {}", "tolerances: {layout003: legacy}", 1)
    with pytest.raises(VehicleError, match="the older layout does not have it"):
        read_vehicle(legacy + "outputs: {lamp: {channel: led_pct}}\n", "rov.yaml")


def test_safe_is_what_the_file_sends_where_nothing_is_said_unless_it_says_otherwise() -> None:
    text = Path("missions/vehicles/coreboard.yaml").read_text(encoding="utf-8")
    text = text.replace("usbl_on: 0", "usbl_on: 1").replace("{channel: usbl_on, safe: 0}",
                                                             "{channel: usbl_on}")  # fmt: skip
    output = read_vehicle(text, "coreboard.yaml").output("usbl")
    assert output is not None
    assert output.safe == 1


@pytest.mark.parametrize("row", list(VEHICLES.values()), ids=lambda row: row.name)
def test_every_channel_is_at_rest_within_its_bounds(row) -> None:
    for channel in row.channels:
        assert channel.rest != channel.rest or channel.fault(channel.rest) == ""


def test_shipped_files_name_no_output_that_a_limit_needs_off_in_an_emergency() -> None:
    for name in ("rov", "coreboard", "robot"):
        for output in load_vehicle(name).outputs:
            assert not output.needed or output.safe == 1
