"""For each row of each document: where it is read, written, flown and tested; found by trying.

    read      the field is changed in a good frame: what of the message that the codec makes changes
    written   each axis, order, output and key is changed: which changes the field
    flown     the simulated board says or hears the frame; of what it says, whether it varies, or by
              which fault
    tested    the test files that have a case of their own for the row

Nothing is kept by hand but why a row has no reader or writer here (``NOBODY``).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from typing import Any

from links.simulated.settings import SettingError, parse_settings
from mission.model.shipped import load_vehicle
from mission.model.vehicle import Vehicle
from mission.topside import words
from mission.verification.rig.vehicle import simulated
from protocol.codec import CannotEncode
from protocol.examples import examples
from protocol.fields import BinaryFrame, FrameType, Number, Raw
from protocol.framing import Frame
from protocol.messages import FrameFault, Order, Setpoint, Telemetry
from protocol.motion_frame import MotionFrame
from protocol.tolerances import Tolerances
from protocol.topside import ConsoleCodec, TopsideCodec
from protocol.vehicles import VEHICLES, VehicleRow, codec, frame_types, link
from protocol.vehicles.channels import Channel
from protocol.vehicles.keys import Key, Octets
from protocol.vehicles.motorcan import CanFrame
from protocol.vehicles.robot import COMMANDS

DOCUMENTS = {"000": "auv", "002": "coreboard", "003": "rov", "004": "robot"}
UP = {
    "auv.SD": "auv",
    "coreboard.MAIN_TO_PC": "coreboard",
    "rov.UP": "rov",
    "robot.UP": "robot",
    "coreboard.SENSOR_TO_MAIN": "mainboard",
}
DOWN = {"coreboard.PC_TO_MAIN": "coreboard", "rov.DOWN": "rov", "robot.DOWN": "robot"}
DOWN |= {"coreboard.CAN_FORCE": "motorcan", "coreboard.CAN_TORQUE": "motorcan", "auv.ZA": "auv"}
DOWN |= {"coreboard.MAIN_TO_SENSOR": "mainboard"}
RELAYED = ("RS", "RI", "D", "MD", "MT", "MM", "MR", "MS", "MP")  # to the AUV's STM32
TOOLS = "`decode`, `listen`"
BY_HAND = "`encode`, `send --port`"
DERIVED = ("flags", "effective", "valid_bits", "at")  # what a reader adds to the rows
NOBODY = {  # fields that nothing of ours asks for or sets, and why
    "coreboard.MAIN_TO_PC": {"reserved50": "kept as it comes", "reserved83": "kept as it comes"},
    "coreboard.PC_TO_MAIN": {
        "lat_deg": "a target of the board's own navigation: the Pi steers",
        "lon_deg": "a target of the board's own navigation: the Pi steers",
        "x_m": "a target of the board's own navigation: the Pi steers",
        "y_m": "a target of the board's own navigation: the Pi steers",
        "ty": "no set has a sideways force",
        "mx": "no set has this torque",
        "my": "no set has this torque",
        "mode": "ROV, in which the six forces act",
    },
    "coreboard.CAN_FORCE": {"fy_g": "no set has a sideways force"},
    "coreboard.CAN_TORQUE": {"mx_nm": "no set has this torque", "my_nm": "no set has this torque"},
    "coreboard.SENSOR_TO_MAIN": {
        "reserved12": "kept as it comes",
        "reserved18": "kept as it comes",
        "reserved124": "kept as it comes",
        "buf": "kept as it comes",
        "leak_legacy_raw": "compared with `leak` alone (E-B5)",
    },
    "rov.DOWN": {"reserved": "sent as 0"},
}
_SETS: tuple[tuple[str, Setpoint | Order], ...] = (
    ("X", Order.STOP),
    ("W", Order.SURFACE),
    ("surge", Setpoint(surge=0.5)),
    ("surge", Setpoint(surge=-0.5)),
    ("turn", Setpoint(turn=0.5)),
    ("turn", Setpoint(turn=-0.5)),
    ("heave", Setpoint(heave=0.5)),
    ("heave", Setpoint(heave=-0.5)),
    ("heading and depth", Setpoint(heading=1.0, depth=3.0)),
    ("heading", Setpoint(heading=1.0)),
    ("depth", Setpoint(depth=3.0)),
    ("altitude", Setpoint(altitude=3.0)),
    ("attitude", Setpoint(pitch=0.1, roll=0.1)),
)
Row = tuple[str, str, str, str, str, str]  # frame, field, read, written, flown, tested


def rows_table(document: str) -> str:
    """Markdown: all rows of one document."""
    head = ("frame", "field", "read", "written", "flown", "tested")
    lines = [head, ("---",) * len(head), *rows(document)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def rows(document: str) -> Iterator[Row]:
    for name, frame in frame_types().items():
        if frame.title.startswith(document):
            for field, says in fields(frame):
                tested = ", ".join(f"`{file}`" for file in tested_by(name, field))
                reads, writes = _read(name, field), written(name, field)
                yield f"`{name}`", says, reads, writes, _flown(name, field), tested


def fields(frame: FrameType) -> Iterator[tuple[str, str]]:
    """The name of each row, and as it is shown; what has none is a row as a whole."""
    if frame.name == "robot.DOWN":
        for row in COMMANDS:
            yield f"{row.address}:{row.command}", f"{row.address}, {row.command:02X} {row.name}"
        return
    if isinstance(frame, MotionFrame):
        yield from ((code, f"`{code}`") for code in frame.words)
        return
    table = frame.table if isinstance(frame, CanFrame) else frame
    seen = [name for raw in _raws(frame.name) for name in table.decode(raw)]
    names = [name for name in dict.fromkeys(seen) if name not in DERIVED]
    yield from ((name, f"`{name}`") for name in names) if names else [("", "(none)")]


def _raw(name: str) -> bytes:
    return _raws(name)[0]


def _raws(name: str) -> list[bytes]:
    return [example.raw for example in examples() if example.type == name]


# --- read ----------------------------------------------------------------------------------------


def _read(name: str, field: str) -> str:
    if why := NOBODY.get(name, {}).get(field):
        return why
    if name in UP:
        return _telemetry_of(name, field) or TOOLS
    if (message := _message(name)) is not None:
        return f"`{type(message).__name__}`"
    return TOOLS


def _telemetry_of(name: str, field: str) -> str:
    """What of a Telemetry changes with the field."""
    frame = frame_types()[name]
    assert isinstance(frame, BinaryFrame)
    item = next(f for f in frame.fields if isinstance(f, Number | Raw) and f.name == field)
    values = dict(frame.decode(_raw(name)))
    other = values | {field: another(item, values[field])}
    before, after = (_telemetry(name, frame.encode(v)) for v in (values, other))
    for one in Telemetry._fields:
        if getattr(before, one) != getattr(after, one):
            return f"`Telemetry.{one}`"
    return ""


def another(item: Number | Raw, value: Any) -> Any:
    if isinstance(item, Raw):
        return "01" + str(value)[2:]
    if item.choices:
        return next(choice for choice in item.choices if choice != value)
    return value - 1 if value >= 1 else value + 1


def _telemetry(name: str, raw: bytes) -> Telemetry:
    """The last of six: a leak is confirmed by three."""
    row = _row(UP[name])
    board = codec(row.name, row.dialects[0], {})
    found = [one for t in range(6) for one in board.receive(raw, float(t))]
    last = found[-1]
    assert isinstance(last, Telemetry)
    return last._replace(t=0.0)


def _message(name: str) -> object | None:
    """What the Pi or the boat makes of the frame."""
    for reader in (TopsideCodec, ConsoleCodec):
        found = reader().receive(_raw(name), 0.0)
        if found and not isinstance(found[0], FrameFault):
            return found[0]
    return None


# --- written -------------------------------------------------------------------------------------


def written(name: str, field: str) -> str:
    if why := NOBODY.get(name, {}).get(field):
        return why
    if name in DOWN:
        return ", ".join(_causes(name, field)) or BY_HAND
    if name in UP:
        return "the board"
    word = name.removeprefix("auv.")
    return f"`send {word}`" if word in words.frame_types() else "`serve`"


def _causes(name: str, field: str) -> Iterator[str]:
    """Axes and orders, outputs, keys of ``wire``; of words of their own all that say them."""
    own = name in ("robot.DOWN", "auv.ZA")
    changed = dict.fromkeys(
        cause
        for cause, said, usual in _tried(DOWN[name])
        if (now := _of(said, name, field)) and (own or now != _of(usual, name, field))
    )
    yield from (f"`{cause}`" for cause in list(changed)[:4])
    if len(changed) > 4:
        yield "..."


Said = tuple[tuple[str, Mapping[str, Any]], ...]  # frames that leave, with their values


@functools.cache
def _tried(board: str) -> tuple[tuple[str, Said, Said], ...]:
    """What may change a frame, what is said then, and what otherwise; what there is no word for is
    left out."""
    row, found = _row(board), list[tuple[str, Said, Said]]()
    usual = _said(row, Setpoint()) or ()
    for axis, wanted in _SETS:
        if (said := _said(row, wanted)) is not None:
            found.append((axis, said, usual))
    for channel in row.channels:
        for level in _levels(channel):
            beside = {"side": 7.0} if channel.name.startswith("side_") else {}
            said = _said(row, Setpoint(), levels={**beside, channel.name: level})
            if said is not None and said != usual:
                found.append((f"output {channel.name}", said, usual))
    for key in row.keys:
        for _, wanted in _SETS:
            before, said = _said(row, wanted), _said(row, wanted, wire={key.name: _other(key)})
            if before is not None and said is not None and said != before:
                found.append((f"key {key.name}", said, before))
    return tuple(found)


def _levels(channel: Channel) -> tuple[float, ...]:
    """All of a few, the ends of many, and what it is at rest."""
    if channel.whole and channel.high - channel.low <= 8:
        few = tuple(range(int(channel.low), int(channel.high) + 1))
        return channel.choices or few
    ends = channel.low, channel.high
    return ends if math.isnan(channel.rest) else (*ends, channel.rest)


def _other(key: Key | Octets) -> str:
    if isinstance(key, Octets):
        return "01" * (len(key.default) // 2)
    return str(key.high if key.high != key.default else key.low)


def _said(
    row: VehicleRow,
    wanted: Setpoint | Order,
    levels: Mapping[str, float] | None = None,
    wire: Mapping[str, str] | None = None,
) -> Said | None:
    try:
        board = codec(row.name, row.dialects[0], {}, wire=wire or {})
        frames = [*board.take_outputs(levels or {}).values(), *board.encode(wanted)]
    except (CannotEncode, ValueError):
        return None
    framer = link(_LINKS[row.name]).framer(Tolerances())
    read = (item for raw in frames for item in framer.receive(raw, 0.0))
    return tuple((item.type.name, item.values()) for item in read if isinstance(item, Frame))


def _of(said: Said, name: str, field: str) -> list[object]:
    return [one for frame, values in said if frame == name for one in _field(name, field, values)]


def _field(name: str, field: str, values: Mapping[str, Any]) -> Iterator[object]:
    if name == "robot.DOWN":
        address, _, command = field.partition(":")
        if (values["address"], values["command"]) == (int(address), int(command)):
            yield values["user"]
    elif name == "auv.ZA":
        if values["code"] == field:
            yield values
    else:
        yield values[field]


_LINKS_UP = {
    "auv.SD": "auv.from_stm32",
    "coreboard.MAIN_TO_PC": "coreboard.main_to_pc",
    "coreboard.SENSOR_TO_MAIN": "coreboard.sensor_to_main",
    "rov.UP": "rov.up",
    "robot.UP": "robot.up",
}
_LINKS = {
    "auv": "auv.to_stm32",
    "coreboard": "coreboard.pc_to_main",
    "motorcan": "coreboard.can",
    "mainboard": "coreboard.main_to_sensor",
    "rov": "rov.down",
    "robot": "robot.down",
}


# --- flown, tested -------------------------------------------------------------------------------


def _flown(name: str, field: str) -> str:
    board = UP.get(name) or DOWN.get(name)
    if name not in UP:
        return "simulated board" if board else "simulated boat and Pi"
    if _varies(name, field):
        return "varies"
    return next((f"by `fault={f}`" for f in _FAULTS if _varies(name, field, f)), "constant")


def _varies(name: str, field: str, *faults: str) -> bool:
    return len({repr(values[field]) for values in _said_by(name, *faults)}) > 1


@functools.cache
def _said_by(name: str, *faults: str) -> tuple[Mapping[str, Any], ...]:
    """What a simulated board reports in 30 s: at rest, under way and down, round; as its vehicle
    file has it, with its sensors switched on. Nothing where it cannot have such a fault."""
    vehicle, framer = load_vehicle(UP[name]), link(_LINKS_UP[name]).framer(Tolerances())
    try:
        line = simulated(vehicle, 1, parse_settings([f"fault={f}@15" for f in faults])).vehicle_link
    except SettingError:
        return ()
    board, found = codec(*vehicle.speaks), list[Mapping[str, Any]]()
    switches = {c.name: c.high for c in _row(vehicle.codec).channels if c.name in _SENSORS}
    for tick in range(300):
        now = tick / 10
        said = [*board.take_outputs(switches).values()] if switches else []
        said += board.encode(_wanted(now, vehicle))
        if name == "auv.SD":  # it has rudders, and hears one word at a time
            said.append(b"@DS%d,%d$" % (1 + tick // 8 % 2, -15 if now < 15.0 else 20))
            said = [] if tick % 4 else [said[tick // 4 % len(said)]]
        for raw in said:
            line.send(raw, now)
        heard = (item for rx in line.receive(now) for item in framer.receive(rx.data, rx.t))
        found += [dict(i.values()) for i in heard if isinstance(i, Frame) and i.type.name == name]
    return tuple(found)


_FAULTS = ("leak", "battery_low")
_SENSORS = ("ins_on", "dvl_on", "usbl_on")


def _wanted(now: float, vehicle: Vehicle) -> Setpoint:
    if now < 8.0:
        return Setpoint()
    if now > 20.0:
        return Setpoint(turn=0.5)
    return Setpoint(surge=0.5, heave=None if vehicle.drives else 0.5)


def tested_by(name: str, field: str) -> Iterator[str]:
    """Each has a case for every such row; the tests see to it."""
    yield "test_rows_of_documents"
    if (name, field) in SAID:
        yield "test_every_row_by_hand"


def _row(name: str) -> VehicleRow:
    return VEHICLES[name]


ROWS = [(name, row) for name, frame in frame_types().items() for row, _ in fields(frame)]
TO_BOARDS = {**DOWN, **dict.fromkeys((f"auv.{word}" for word in RELAYED), "auv")}
SAID = [(name, row) for name, row in ROWS if name in TO_BOARDS]
