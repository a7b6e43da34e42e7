"""Faults of sensors that were added: seen of the one that lies, and of no other; over when over."""

from __future__ import annotations

import functools

import pytest

from links.simulated.added import LIES, SENSORS
from links.simulated.faults import FAULTS
from links.simulated.link import SimulatedVehicle
from links.simulated.settings import SettingError, parse_settings

BEGIN, END, UNTIL = 20, 43, 65  # s
FITTED = (
    *("speed_log=0.05", "doppler=0.03", "acoustic=3", "ranges=2", "second_gps=3"),
    *("beacon=1@30.288,120.154,4", "beacon=2@30.286,120.152,8", "current=0.3@90"),
)
OF_SENSOR = {"speed_log": b"$VDVHW", "doppler": b":", "acoustic": b"$VDGLL", "ranges": b"$CAMPR"}
LIED = [f"{sensor}_{how}" for sensor in SENSORS for how in LIES]
SECOND = [name for name in FAULTS if name.startswith("gps2_")]
Lines = list[tuple[int, bytes]]


@functools.cache
def said(fault: str = "") -> dict[str, Lines]:
    """By sensor, with the second that each line is of."""
    events = [f"fault={fault}@{BEGIN}+{END - BEGIN}"] if fault else []
    settings = parse_settings([*FITTED, *events])
    vehicle = SimulatedVehicle("as-built", 3, settings)
    assert vehicle.added_link is not None
    assert vehicle.second_link is not None
    found: dict[str, Lines] = {name: [] for name in (*SENSORS, "gps2")}
    for rx in vehicle.added_link.receive(UNTIL):
        for line in rx.data.splitlines():
            name = next(name for name, begin in OF_SENSOR.items() if line.startswith(begin))
            found[name].append((int(rx.t), line))
    found["gps2"] = [(int(rx.t), rx.data) for rx in vehicle.second_link.receive(UNTIL)]
    return found


def during(lines: Lines) -> Lines:
    """From the second after its begin; by then a position every 5 s has been said."""
    return [line for line in lines if BEGIN < line[0] < END]


@pytest.mark.parametrize("fault", LIED)
def test_one_added_sensor_lies_while_the_others_say_the_truth(fault: str) -> None:
    lies = fault.rpartition("_")[0]
    for sensor, honest in said().items():
        heard = said(fault)[sensor]
        assert (during(heard) == during(honest)) == (sensor != lies)
        for begin, end in ((0, BEGIN), (END + 1, UNTIL)):
            assert [x for x in heard if begin <= x[0] < end] == [
                x for x in honest if begin <= x[0] < end
            ]


@pytest.mark.parametrize("sensor", SENSORS)
def test_what_is_frozen_repeats_its_last_word_at_its_usual_times(sensor: str) -> None:
    heard, honest = said(f"{sensor}_frozen")[sensor], said()[sensor]
    assert [t for t, _ in heard] == [t for t, _ in honest]
    before = [line for t, line in honest if t < BEGIN]
    parts = sum(t == honest[0][0] for t, _ in honest)
    assert {line for _, line in during(heard)} == set(before[-parts:])
    assert said(f"{sensor}_silent")[sensor] == [x for x in honest if not BEGIN <= x[0] < END]


@pytest.mark.parametrize("fault", SECOND)
def test_the_second_receiver_fails_by_itself_and_is_well_again(fault: str) -> None:
    heard, honest = said(fault), said()
    if fault != "gps2_wanders":  # that one makes places up where there is no sky
        assert during(heard["gps2"]) != during(honest["gps2"])
    assert {name: heard[name] for name in SENSORS} == {name: honest[name] for name in SENSORS}
    last = heard["gps2"][-1]
    assert last[0] == honest["gps2"][-1][0]
    assert last[1].split(b",")[2][:7] == honest["gps2"][-1][1].split(b",")[2][:7]


@pytest.mark.parametrize("fault", ["doppler_wild", "gps2_stuck"])
def test_what_is_not_fitted_cannot_fail(fault: str) -> None:
    needs = FAULTS[fault].needs
    with pytest.raises(SettingError, match=rf"fault={fault}: it has none; --set {needs}="):
        SimulatedVehicle("as-built", 3, parse_settings([f"fault={fault}@5"]))
