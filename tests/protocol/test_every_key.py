"""Every key that a document leaves open (A8 of the vehicle file: `tolerances`, `wire`) changes what is
read or what leaves, and docs/protocol.md has it with its default."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from protocol.codec import CannotEncode
from protocol.examples import examples
from protocol.framing import Frame
from protocol.messages import Order, Setpoint
from protocol.tolerances import TOLERANCES, Tolerance, Tolerances
from protocol.topside import ConsoleCodec
from protocol.vehicles import VEHICLES, VehicleRow, codec, links
from protocol.vehicles.keys import Key, Octets

PAGE = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text(encoding="utf-8")
STATUS = next(e.raw for e in examples() if e.type == "auv.VS")
CORE = next(e.raw for e in examples() if e.type == "coreboard.MAIN_TO_PC")
DOWN = next(e.raw for e in examples() if e.type == "rov.DOWN")
BESIDE = (  # what some value of a tolerance alone takes, or refuses
    b"@AW\x02\x00\x01\x00@ZAF5$$",
    b"@AW\x02\x00\x00\x00ZAF5$",
    b"@AW0201ZAF5$",
    b"@ST,20250119232625,$",
    b"@ST,2025,01,19,23,26,25,$",
    b"@MS0,90$",
    b"@ZAA5,-3$",
    b"@ZAH-20,4$",
    b"@ACK_RSY$",
    STATUS.replace(b"@VS", b"@"),
    STATUS.replace(b"@VS", b"@VS,"),
    STATUS.replace(b",20,100,", b",20,", 1),
    STATUS.replace(b",20,100,", b",,100,", 1),
    CORE[:-2] + b"\xfd\xdf",
    DOWN[:3] + b"\x15" + DOWN[4:],
    bytes.fromhex("AA 01 20 02 F4 01 00 00 00 00 C2 DD"),  # the sum is 450 = 194 mod 256
)
SAID = (
    *(Setpoint(surge=s) for s in (0.5, -0.5)),
    *(Setpoint(turn=s) for s in (0.5, -0.5)),
    *(Setpoint(heave=s) for s in (0.5, -0.5)),
    *(Setpoint(surge=0.5, heading=1.0, depth=3.0), Setpoint(pitch=0.1, roll=0.1)),
    *(Order.STOP, Order.SURFACE),
)
STICK = (b"@MMF6$", b"@MRR3$", b"@MMD6$")


def read(tolerances: Tolerances) -> Iterator[object]:
    """What every link makes of every example, and of the frames beside them."""
    for row in links():
        for raw in (*own_examples(row.name.partition(".")[0]), *BESIDE):
            framer = row.framer(tolerances)
            for item in (*framer.receive(raw, 0.0), *framer.flush(1e9)):
                yield (item.type.name, item.values()) if isinstance(item, Frame) else item
    console = ConsoleCodec(tolerances)
    yield [console.receive(raw, 0.0) for raw in (STATUS, b"@ACK_RSY$")]


def written(tolerances: Tolerances) -> Iterator[object]:
    """Every frame said anew with its own values."""
    known = {(frame.name): frame for row in links() for frame in row.frames(tolerances)}
    for example in examples():
        frame = known[example.type]
        try:
            yield frame.encode(example_values(example.type))
        except (CannotEncode, ValueError, KeyError) as error:
            yield str(error)


@functools.cache
def _usual() -> dict[str, Any]:
    return {frame.name: frame for row in links() for frame in row.frames(Tolerances())}


def example_values(name: str) -> dict[str, Any]:
    raw = next(e.raw for e in examples() if e.type == name)
    return {k: v for k, v in _usual()[name].decode(raw).items() if k != "flags"}


def taken(name: str, tolerances: dict[str, str], wire: dict[str, str]) -> list[object]:
    """What a vehicle's codec says of every set and stick, and makes of every report."""
    row = VEHICLES[name]
    board = codec(name, row.dialects[0], tolerances, wire=wire)
    found: list[object] = []
    for wanted in SAID:
        try:
            found.append(board.encode(wanted))
        except CannotEncode as error:
            found.append(str(error))
    for word in STICK if hasattr(board, "stick") else ():
        try:
            found.append(board.encode(board.stick(Setpoint(), word)))
        except CannotEncode as error:
            found.append(str(error))
    for raw in own_examples("coreboard" if name == "mainboard" else name):
        found += [board.receive(raw, float(t)) for t in range(6)]
    return found


@functools.cache
def own_examples(family: str) -> tuple[bytes, ...]:
    return tuple(e.raw for e in examples() if e.type.startswith(f"{family}."))


@functools.cache
def usual_readings() -> list[str]:
    return [*map(repr, read(Tolerances())), *map(repr, written(Tolerances()))]


@pytest.mark.parametrize(
    ("tolerance", "value"),
    [(t, v) for t in TOLERANCES for v in (t.values[1:4] or ("0x123",))],
    ids=lambda v: getattr(v, "name", v),
)
def test_every_value_of_a_tolerance_changes_what_is_read_or_written(
    tolerance: Tolerance, value: str
) -> None:
    chosen = {tolerance.name: value}
    parsed = Tolerances.parse(chosen)
    now = [*map(repr, read(parsed)), *map(repr, written(parsed))]
    if now == usual_readings():
        pairs = ((taken(name, chosen, {}), taken(name, {}, {})) for name in VEHICLES)
        assert any(one != other for one, other in pairs)


KEYS = [(row, key) for row in VEHICLES.values() for key in row.keys if key.name != "baud"]


@pytest.mark.parametrize(("row", "key"), KEYS, ids=lambda v: v.name)
def test_every_key_of_the_wire_changes_what_the_board_is_told_or_what_it_tells(
    row: VehicleRow, key: Key | Octets
) -> None:
    """The rate of the line is read back from the port: test_ports."""
    steps = {"angle_error_step": {"angle_error_deg": "5"}}.get(key.name, {})
    if isinstance(key, Octets):
        other = "01" * (len(key.default) // 2)
    else:
        other = str(key.low if key.high == key.default else key.high)
        other = "0" if key.name.endswith("_rpm") else other
        other = {"torque_step": "0.5", "speed_step": "10", "angle_error_step": "0.5"}.get(
            key.name, other
        )
    assert taken(row.name, {}, {**steps, key.name: other}) != taken(row.name, {}, steps)


@pytest.mark.parametrize("name", [t.name for t in TOLERANCES])
def test_every_tolerance_is_in_the_reference_with_its_default_first(name: str) -> None:
    values = next(t.values for t in TOLERANCES if t.name == name)
    (said,) = re.findall(rf"^\| `{name}` +\| ([^|]+?) +\|", PAGE, re.M)
    assert said.startswith(values[0] if values else "an identifier")


@pytest.mark.parametrize(
    ("row", "key"), [(r, k) for r in VEHICLES.values() for k in r.keys], ids=lambda v: v.name
)
def test_every_key_is_in_the_reference_with_its_default(row: VehicleRow, key: Key | Octets) -> None:
    page = PAGE[PAGE.index("## Keys of the vehicle file") :]
    page = page[: page.index("\n## ", 5)]
    (default,) = re.findall(rf"^\| {row.name} +\| `{key.name}` +\| (\S+) +\|", page, re.M)
    if isinstance(key, Octets):
        assert default == key.default
    else:
        assert float(default) == float(key.default)
