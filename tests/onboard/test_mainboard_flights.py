"""Missions of the vehicle whose main board is the Pi, and its drop weight."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from links.simulated.boards import SimulatedBoard
from links.simulated.settings import parse_settings
from mission.authoring.prepare import prepare
from mission.model.shipped import load_vehicle, vehicle_file
from mission.model.vehicle import Vehicle, VehicleError
from mission.model.vehicle_file import read_vehicle
from mission.verification.rig.rehearsal import Cue
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight
from protocol.framing import Frame
from protocol.vehicles import link

HEAD = """mission core-dive vehicle mainboard
home 30.2874595 120.1535765
safety radius 500 time 20min depth 20 voltage 12
assume current 0.1
"""
TEXT = f"""{HEAD}dive: depth 4 heading 90 gear 6 output led1 50 until depth >= 3.7 timeout 90s
hold: depth 4 heading 180 gear 4 for 40s
back: goto home depth 3 within 8 gear 6 timeout 3min
up: surface until fix timeout 3min
"""
STAY = f"""{HEAD.replace("20min depth 20", "40min depth 45")}dive: down 9 until depth >= 6 timeout 60s
stay: down 4 for 90s
up: surface timeout 5min
"""


def confirmed() -> Vehicle:
    vehicle = load_vehicle("mainboard")
    assert vehicle.outer_loop is not None
    return replace(vehicle, outer_loop=replace(vehicle.outer_loop, confirmed="2026-11-22"))


def flown(folder: Path, text: str, *said: Cue, faults: tuple[str, ...] = ()) -> Flight:
    vehicle = folder / "vehicle.yaml"
    shipped = vehicle_file("mainboard").read_text(encoding="utf-8")
    vehicle.write_text(shipped.replace("# confirmed: 2026-11-22", "confirmed: 2026-11-22"))
    mission = folder / "m.mission"
    mission.write_text(text, encoding="utf-8")
    ready = prepare(mission, str(vehicle))
    return fly(ready.mission, ready.vehicle, seed=3, said=said, settings=parse_settings(faults))


def weights(flight: Flight) -> list[int]:
    """The switch of the drop weight in each frame to the sensor board."""
    framer = link("coreboard.main_to_sensor").framer()
    frames = (tx.data for tx in flight.sent if tx.link == "vehicle" and tx.data[0] > 7)
    read = [item for data in frames for item in framer.receive(data, 0.0)]
    return [item.values()["drop_weight"] for item in read if isinstance(item, Frame)]


@pytest.mark.proof
def test_with_its_signs_confirmed_it_flies_holds_goes_home_and_comes_up(tmp_path: Path) -> None:
    flight = flown(tmp_path, TEXT)
    legs = [(leg.name, leg.by) for leg in flight.legs]
    assert legs == [
        ("dive", "until"), ("hold", "for"), ("back", "end"), ("up", "end"), ("surface", "end"),
    ]  # fmt: skip
    hold = flight.legs[1]
    held = [s.true.depth for s in flight.samples if hold.entered + 15 < s.t < hold.left]
    assert all(abs(depth - 4.0) < 0.4 for depth in held)
    assert flight.at_surface
    assert not any(weights(flight)), "nothing lets the weight go by itself"


@pytest.mark.proof
def test_the_operator_drops_the_weight_by_name_in_any_state(tmp_path: Path) -> None:
    flight = flown(tmp_path, STAY, Cue(30.0, b"@AO,weight,1,$"))
    dropped = weights(flight)
    first = dropped.index(1)
    assert all(dropped[first:])
    at = next(s.t for s in flight.samples if s.t > 45.0)
    assert next(s.true.depth for s in flight.samples if s.t >= at) < 1.0, "it rises against thrust"


@pytest.mark.proof
def test_an_ascent_that_gains_nothing_lets_it_go_where_the_vehicle_file_arms_it(
    tmp_path: Path,
) -> None:
    """20 N too heavy, and thrusters that are dead: nothing else would bring it up."""
    faults = ("fault=heavy=20@40+100000", "fault=verticals_dead@40+100000")
    flight = flown(tmp_path, STAY, Cue(45.0, b"@ZAWF$"), faults=faults)
    assert 1 in weights(flight)
    assert flight.final_state == "emergency/surfaced"
    assert flight.at_surface


def test_a_drop_weight_is_named_as_what_cannot_be_taken_back_or_refused() -> None:
    text = vehicle_file("mainboard").read_text(encoding="utf-8")
    text = text.replace(", irreversible: true, ascent: 1", "")
    with pytest.raises(VehicleError) as caught:
        read_vehicle(text, "vehicle.yaml")
    assert "cannot be taken back: say irreversible: true" in str(caught.value)


@pytest.mark.proof
def test_leds_and_switches_are_safe_again_in_an_emergency(tmp_path: Path) -> None:
    flight = flown(tmp_path, TEXT, Cue(30.0, b"@ZAWF$"))
    framer = link("coreboard.main_to_sensor").framer()
    leds = [
        item.values()["led1"]
        for tx in flight.sent
        if tx.link == "vehicle" and tx.data[0] > 7
        for item in framer.receive(tx.data, tx.t)
        if isinstance(item, Frame)
    ]
    assert max(leds) == 50
    assert leds[-1] == 0


def test_its_simulated_board_needs_power_as_the_real_one() -> None:
    board = SimulatedBoard("mainboard", 1)
    framer = link("coreboard.sensor_to_main").framer()
    board.advance(10.0)
    reports = [
        item.values()
        for rx in board.vehicle_link.receive(10.0)
        for item in framer.receive(rx.data, rx.t)
        if isinstance(item, Frame)
    ]
    assert len(reports) == pytest.approx(100, abs=2)
    assert not any(values["ins_aligned"] for values in reports), "nobody has switched its INS on"
