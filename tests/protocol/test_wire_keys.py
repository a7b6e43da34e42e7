"""The keys of ``wire``: the document decides unless the vehicle file says otherwise."""

from __future__ import annotations

import pytest

from protocol.messages import Order, Setpoint
from protocol.vehicles import VEHICLES, VehicleRow, codec, link
from protocol.vehicles.keys import Key, UnknownKey, read_wire

KEYS = [(row, key) for row in VEHICLES.values() for key in row.keys]
NUMBERS = [(row, key) for row, key in KEYS if isinstance(key, Key)]
WHOLE = [(row, key) for row, key in NUMBERS if key.whole]
ids = {"ids": lambda value: value.name}


def values(wire: dict[str, str]) -> dict[str, object]:
    (raw,) = codec("coreboard", "documented", {}, wire=wire).encode(Order.STOP)
    (frame,) = link("coreboard.pc_to_main").framer().receive(raw, 0.0)
    return frame.values()  # type: ignore[union-attr]


@pytest.mark.parametrize("row", list(VEHICLES.values()), ids=lambda row: row.name)
def test_every_vehicle_says_the_rate_of_its_line_as_its_document_does(row: VehicleRow) -> None:
    documented = {"auv": 9600, "motorcan": 500_000, "mainboard": 500_000}
    assert read_wire(row.keys, {})["baud"] == documented.get(row.name, 115_200)
    assert read_wire(row.keys, {"baud": "19200"})["baud"] == 19_200


@pytest.mark.parametrize(("row", "key"), KEYS, **ids)
def test_a_default_said_aloud_changes_no_byte(row: VehicleRow, key: Key) -> None:
    plain = codec(row.name, row.dialects[0], {})
    said = codec(row.name, row.dialects[0], {}, wire={key.name: str(key.default)})
    for command in (Order.STOP, Order.SURFACE, Setpoint(surge=0.5)):
        assert said.encode(command) == plain.encode(command)


@pytest.mark.parametrize(("row", "key"), KEYS, **ids)
def test_a_value_that_is_none_is_refused_with_what_is_possible(row: VehicleRow, key: Key) -> None:
    for text in ("much", "", "nan", "1e99"):
        with pytest.raises(UnknownKey, match=key.name) as told:
            codec(row.name, row.dialects[0], {}, wire={key.name: text})
        assert key.allowed in str(told.value)


@pytest.mark.parametrize(("row", "key"), NUMBERS, **ids)
def test_a_number_is_taken_to_its_ends_and_no_further(row: VehicleRow, key: Key) -> None:
    for end, beyond in ((key.low, key.low - 0.001), (key.high, key.high + 1)):
        assert key.read(str(end)) == end
        with pytest.raises(UnknownKey):
            key.read(str(beyond))


@pytest.mark.parametrize(("row", "key"), WHOLE, **ids)
def test_a_whole_number_has_no_fraction(row: VehicleRow, key: Key) -> None:
    with pytest.raises(UnknownKey, match="a whole number"):
        key.read(str(key.high - 0.5))


def test_an_unknown_key_is_refused_with_those_there_are() -> None:
    with pytest.raises(UnknownKey, match=r"no key full_spede.*baud, .*full_speed"):
        codec("robot", "documented", {}, wire={"full_spede": "100"})


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("nav", "2", 2),
        ("ins_on", "0", 0),
        ("dvl_on", "0", 0),
        ("usbl_on", "1", 1),
        ("usbl_khz", "48", 48),
        ("angle_error_deg", "-3", -3),
        ("passthrough", "0102030405060708090A0B", "0102030405060708090a0b"),
    ],
)
def test_each_auxiliary_byte_of_the_core_board_goes_out_as_configured(
    name: str, text: str, value: object
) -> None:
    usual, changed = values({}), values({name: text})
    assert changed.pop(name) == value
    assert usual.pop(name) != value
    assert changed == usual


def test_the_angle_error_is_counted_in_the_steps_of_the_board() -> None:
    assert values({"angle_error_deg": "2.5", "angle_error_step": "0.1"})["angle_error_deg"] == 25


@pytest.mark.parametrize(
    ("name", "wire"),
    [
        ("coreboard", {"angle_error_deg": "20", "angle_error_step": "0.1"}),
        ("robot", {"full_speed": "32767", "speed_step": "0.5"}),
        ("motorcan", {"turn_nm": "1000", "torque_step": "0.01"}),
    ],
)
def test_what_has_no_place_in_its_bytes_is_refused_before_anything_is_sent(
    name: str, wire: dict[str, str]
) -> None:
    with pytest.raises(ValueError, match=r"outside|int|format"):
        codec(name, "documented", {}, wire=wire)


def test_the_robot_is_told_its_speed_in_the_steps_of_the_board() -> None:
    robot = codec("robot", "documented", {}, wire={"full_speed": "500", "speed_step": "10"})
    assert robot.encode(Setpoint(surge=0.5))[0][4:6] == (25).to_bytes(2, "little")
    (told,) = robot.receive(bytes.fromhex("AA 19 00 C0 5D E1 DD"), 0.0)
    assert told.velocity == (0.25, 0.0, 0.0)  # type: ignore[union-attr]
