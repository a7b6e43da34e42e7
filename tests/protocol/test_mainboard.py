"""The Pi in the place of the main board (document 002, tables 4-1, 4-2, 5-1, 5-2)."""

from __future__ import annotations

import math

import pytest

from mission.navigation.health import SENSORS, SensorHealth
from protocol.codec import CannotEncode
from protocol.examples import examples
from protocol.framing import Frame
from protocol.messages import Order, Setpoint, Telemetry
from protocol.vehicles import codec, coreboard, link, mainboard
from protocol.vehicles.mainboard import CHANNELS, SOURCES, MainboardCodec

RAW = next(e.raw for e in examples() if e.type == "coreboard.SENSOR_TO_MAIN")


def board() -> MainboardCodec:
    made = codec("mainboard", "documented", {})
    assert isinstance(made, MainboardCodec)
    return made


def told(made: MainboardCodec) -> dict[str, object]:
    """What the sensor board hears with the next word."""
    *_, frame = made.encode(Setpoint())
    (read,) = link("coreboard.main_to_sensor").framer().receive(frame, 0.0)
    assert isinstance(read, Frame)
    return dict(read.values())


def test_at_rest_the_sensors_that_limits_and_position_need_have_power_and_nothing_else() -> None:
    on = {name for name, value in told(board()).items() if value == 1}
    assert on == {"ins", "dvl", "modem", "altimeter", "depth", "ctd"}


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda c: c.name)
def test_each_channel_is_one_field_of_table_4_1(channel: mainboard.Channel) -> None:
    made = board()
    usual = told(made)
    made.take_outputs({channel.name: channel.high if channel.rest != channel.high else 0})
    now = told(made)
    changed = [name for name, value in now.items() if value != usual[name]]
    field = channel.name.removesuffix("_on")
    assert changed == ["passthrough" if field.startswith("passthrough") else field]


def test_a_set_is_force_and_torque_and_orders_are_stop_and_thrust_upward() -> None:
    made, motors = board(), codec("motorcan", "documented", {})
    for one in (Setpoint(surge=0.4, heave=-0.2), Setpoint(turn=1.0), Order.STOP, Order.SURFACE):
        assert made.encode(one)[:2] == motors.encode(one)
    with pytest.raises(CannotEncode, match="hold nothing"):
        made.encode(Setpoint(depth=3.0))


def changed(**values: object) -> Telemetry:
    frame = coreboard.sensor_to_main(coreboard.Tolerances())
    raw = frame.encode(dict(frame.decode(RAW)) | values)
    (found,) = board().receive(raw, 5.0)
    assert isinstance(found, Telemetry)
    return found


def test_table_4_2_is_read_in_si() -> None:
    report = changed(
        depth_m=7.5, altitude_m=4.0, yaw_deg=90.0, roll_deg=10.0, control_v=23.5, power_v=47.0
    )
    assert (report.t, report.depth, report.altitude) == (5.0, 7.5, 4.0)
    assert report.heading == pytest.approx(math.pi / 2)
    assert report.roll == pytest.approx(math.radians(10.0), abs=1e-6)
    assert report.batteries == (23.5, 47.0)


@pytest.mark.parametrize(
    ("valid", "known"), [(0, False), (1, False), (2, True), (4, True), (31, True)]
)
def test_a_position_counts_while_the_board_says_gps_or_ins(valid: int, known: bool) -> None:
    report = changed(lat_deg=30.0, lon_deg=120.0, valid=valid)
    expected = (math.radians(30.0), math.radians(120.0)) if known else None
    assert report.position == (pytest.approx(expected) if known else None)


def test_a_report_of_the_older_layout_keeps_its_values_and_none_is_believed() -> None:
    """E-B4: every check passes; nothing but byte 23 tells. A disagreement of leaks is no layout."""
    frame = coreboard.sensor_to_main(coreboard.Tolerances())
    place = {"lat_deg": 30.0, "lon_deg": 120.0, "valid": 2}
    raw = frame.pack(dict(frame.decode(RAW)) | place | {"depth_m": 7.5, "leak_legacy_raw": 0x9C})
    health = SensorHealth(frozenset(SENSORS))
    made = board()
    for t in range(20):
        (report,) = made.receive(raw, t / 10)
        assert isinstance(report, Telemetry)
        assert not health.telemetry(report) & {"depth", "heading"}
    assert (report.depth, report.position) == (7.5, None)
    assert {"depth_m:layout", "yaw_deg:layout"} <= set(report.faults)
    assert [health.of(name, 1.9).reason for name in ("depth", "heading")] == ["absurd"] * 2
    assert changed(leak=1).faults == ("leak_legacy_raw:disagrees",)


def test_every_source_is_a_field_of_the_report() -> None:
    names = {name for name, _ in changed().board}
    assert names == {source.name for source in SOURCES}


def test_a_leak_is_confirmed_by_three_frames_more_than_deny_it() -> None:
    frame = coreboard.sensor_to_main(coreboard.Tolerances())
    made = board()
    wet = frame.encode(dict(frame.decode(RAW)) | {"leak": 1, "leak_legacy_raw": 0})
    leaks = [made.receive(wet, float(t))[0].leak for t in range(4)]  # type: ignore[union-attr]
    assert leaks == [False, False, True, True]
