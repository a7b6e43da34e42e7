"""The protocol reference, written from the frame tables: ``python -m protocol.reference``.

    links -> one section per type: drawing, table of fields, examples, errata -> tolerances, faults

docs/protocol.md is the output of this program; a test compares the two. After a change of a table,
write the file again. What does not live here: facts about frames. They are in the frame tables,
in protocol.examples, protocol.errata and protocol.units. ``_CELLS`` draws a few text frames that
have no table of items.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence

from protocol.drawing import WIDTH, Cell, drawing, table
from protocol.errata import ERRATA, errata_of
from protocol.examples import examples
from protocol.fields import BinaryFrame, Const, FaultKind, Field, FrameType, Number, Pad, Raw
from protocol.motion_frame import EMERGENCY, MotionFrame
from protocol.reference_channels import channel_tables
from protocol.state_frame import NAMES as STATE_NAMES
from protocol.state_frame import NUMBERS as STATE_NUMBERS
from protocol.state_frame import VERSION, StateFrame
from protocol.status_frame import TABLE, StatusFrame
from protocol.text import Digit, Int, Letters, Sep, TextFrame
from protocol.tolerances import TOLERANCES, Tolerances
from protocol.topside_frames import SafetyFrame
from protocol.units import unit
from protocol.vehicles import READ_ONLY, VEHICLES, frame_types, links
from protocol.vehicles.keys import Key, Octets
from protocol.vehicles.motorcan import CanFrame
from protocol.vehicles.robot import COMMANDS, DownFrame


def _commas(lead: str, *names: str) -> tuple[Cell, ...]:
    """Return cells with a comma before and after every item."""
    inner = [cell for name in names for cell in (("", name), ("", ","))]
    return (("0", lead), (str(len(lead)), ","), *inner, ("", "$"))


_CELLS: dict[str, tuple[Cell, ...]] = {
    "auv.AW": (("0", "@AW"), ("3", "total"), ("5", "current"), ("7", "payload"), ("", "$")),
    "auv.ST": (("0", "@ST"), ("3", ","), ("4", "YYYY/MM/DD hh:mm:ss"), ("23", ","), ("24", "$")),
    "auv.SP": _commas("@SP", *SafetyFrame.ITEMS),
    "auv.AO": _commas("@AO", "name", "value"),
    "auv.AR": _commas("@AR", "state", "total", "have", "missing", "digest", "refusal"),
    "auv.AES": _commas("@AE", f"{VERSION}", *STATE_NAMES),
    "auv.ACK": (("0", "@ACK_"), ("5", "class"), ("6", "func"), ("7", "result"), ("8", "$")),
    "auv.MODEM": (
        *(("0", "23 02"), ("2", "length"), ("4", "address"), ("5", "content")),
        *(("5+n", "crc16_modbus"), ("7+n", "")),
    ),
}
_TYPES = {
    "B": "u8",
    "b": "i8",
    "H": "u16",
    "h": "i16",
    "I": "u32",
    "i": "i32",
    "f": "f32",
    "d": "f64",
}


def reference() -> str:
    """The whole document."""
    return "\n".join(_document()) + "\n"


def _document() -> Iterator[str]:
    yield "# Protocol reference"
    yield ""
    yield "Written by `python -m protocol.reference` from the frame tables: change them, not this."
    yield "Offsets count from 0. `le` is low byte first, `be` high byte first. Names are those of"
    yield "`auvmission decode` and `encode`, values in the units given here."
    yield ""
    yield "Frames with binary bytes are delimited by their length, text frames by the first `$`. A"
    yield "candidate that fails costs one byte, and the search goes on at the next. A command with"
    yield "a value out of range is refused whole; of telemetry the field is kept and flagged."
    yield "Acknowledgements that the STM32 as built prints into an `@SD` are taken out of it, and"
    yield "read like the report."
    yield ""
    yield from _links()
    vehicle = ""
    for name, frame in frame_types().items():
        if name.partition(".")[0] != vehicle:
            vehicle = name.partition(".")[0]
            yield f"## {vehicle}"
            yield ""
        yield from _section(frame)
    yield from _tolerances()
    yield from _keys()
    yield from channel_tables()
    yield from _errata()
    yield from _faults()


def _links() -> Iterator[str]:
    yield "## Links"
    yield ""
    yield "What a decoder is told it listens to. What stays unfinished is given up after the idle"
    yield "time."
    yield ""
    rows = []
    for row in (*links(), *READ_ONLY):
        names = dict.fromkeys(f.name.partition(".")[2] for f in row.frames(Tolerances()))
        rows.append((row.name, ", ".join(names), f"{row.idle * 1000:g} ms"))
    yield from table(("link", "frames", "idle"), rows)
    yield ""


# --- one type ------------------------------------------------------------------------------------


def _section(frame: FrameType) -> Iterator[str]:
    yield f"### {frame.name}"
    yield ""
    layout = frame.table if isinstance(frame, CanFrame) else frame
    cells = _cells(layout)
    size = f"{_length(layout, cells)} bytes" if _length(layout, cells) else "length varies"
    addressed = f", identifier {frame.identifier:03X}" if isinstance(frame, CanFrame) else ""
    yield f"Document {frame.title}; {size}{addressed}."
    yield ""
    yield "```text"
    yield from drawing(cells)
    yield "```"
    yield ""
    rows = list(_rows(layout))
    if rows:
        head = ("offset", "type", "name", "unit", "values")
        yield from table(head if isinstance(layout, BinaryFrame) else head[2:], rows)
        yield ""
    if isinstance(layout, DownFrame):
        yield from _robot_commands()
    yield from _examples(frame)
    names = ", ".join(row.name for row in errata_of(frame.name))
    yield f"Errata: {names or 'none'}."
    yield ""


def _length(frame: FrameType, cells: Sequence[Cell]) -> int:
    """Return 0 if the length varies. In a text frame it is fixed if that of each item is."""
    where, what = cells[-1]
    return frame.length or (int(where) + 1 if what == "$" and where else 0)


def _cells(frame: FrameType) -> tuple[Cell, ...]:
    if isinstance(frame, BinaryFrame):
        pairs = zip(frame.fields, frame.offsets, strict=True)
        return (*((str(at), _label(item)) for item, at in pairs), (str(frame.length), ""))
    if frame.name in _CELLS:
        return _CELLS[frame.name]
    lead = ("0", frame.lead.decode("ascii"))
    if isinstance(frame, StatusFrame):
        names = [cell for item in TABLE for cell in (("", item.name), ("", ","))]
        return (lead, *names[:-1], ("", "$"))
    if isinstance(frame, MotionFrame):
        return (lead, ("3", "code"), ("4", "value"), ("", "$"))
    assert isinstance(frame, TextFrame)
    return (lead, *_text_cells(frame))


def _text_cells(frame: TextFrame) -> Iterator[Cell]:
    at: int | None = len(frame.lead)
    for item in frame.items:
        where = "" if at is None else str(at)
        yield where, item.char if isinstance(item, Sep) else item.name
        size = 1 if isinstance(item, Sep) else item.size
        at = at + size if at is not None and size else None
    yield "" if at is None else str(at), "$"


def _label(item: Field) -> str:
    match item:
        case Number() | Raw():
            return item.name
        case Const():
            return _bytes(item.data)
        case Pad():
            return "-"
        case _:
            return item.compute.__name__


def _bytes(data: bytes) -> str:
    """Letters as they are (@SD), anything else in hexadecimal."""
    return (
        data.decode("ascii")
        if data.isascii() and data[:1] in (b"@", b"$")
        else data.hex(" ").upper()
    )


def _rows(frame: FrameType) -> Iterator[tuple[str, ...]]:
    if isinstance(frame, BinaryFrame):
        for item, at in zip(frame.fields, frame.offsets, strict=True):
            yield str(at), *_binary_row(frame, item)
    elif isinstance(frame, StatusFrame):
        for entry in TABLE:
            yield entry.name, unit(frame.name, entry.name), _range(entry.low, entry.high)
    elif isinstance(frame, StateFrame):
        for entry in STATE_NUMBERS:
            yield entry.name, unit(frame.name, entry.name), _range(entry.low, entry.high)
    elif isinstance(frame, MotionFrame):
        yield from _motion_rows(frame)
    elif isinstance(frame, TextFrame):
        for part in frame.items:
            if not isinstance(part, Sep):
                yield part.name, unit(frame.name, part.name), _choices(part)


def _binary_row(frame: BinaryFrame, item: Field) -> tuple[str, str, str, str]:
    match item:
        case Number():
            return _number_type(item), item.name, unit(frame.name, item.name), _number_range(item)
        case Raw(size=size):
            return _size(size), item.name, "", "hexadecimal"
        case Const():
            return _size(len(item.data)), "", "", _bytes(item.data)
        case Pad():
            return _size(item.size), "", "", "sent as 0, ignored"
        case _:
            last = frame.offsets[frame.fields.index(item)] - 1
            size = struct.calcsize("<" + item.code)
            order = " le" if size > 1 else ""
            covers = f"{item.compute.__name__} of {item.first}..{last}"
            return f"u{8 * size}{order}", "", "", covers


def _size(count: int) -> str:
    return "1 byte" if count == 1 else f"{count} bytes"


def _number_type(item: Number) -> str:
    kind = _TYPES[item.code]
    if kind[1:] == "8":
        return kind
    return f"{kind} {'le' if item.order == '<' else 'be'}"


def _number_range(item: Number) -> str:
    told = (
        [_range(item.low, item.high)] if not item.choices else [", ".join(map(str, item.choices))]
    )
    if item.scale != 1:
        told.append(f"counts / {item.scale:g}")
    if item.bias:
        told.append(f"counts - {item.bias:g}")
    return "; ".join(text for text in told if text)


def _range(low: float | None, high: float | None) -> str:
    bounds = [
        None if x is None or x in (float("inf"), float("-inf")) else f"{x:.9g}" for x in (low, high)
    ]
    if bounds == [None, None]:
        return ""
    return f"{bounds[0] or ''}..{bounds[1] or ''}"


def _choices(part: Letters | Digit | Int) -> str:
    if isinstance(part, Int):
        return f"{part.low}..{part.high}"
    count = f"{part.size} of " if part.size > 1 else ""
    return count + " ".join(part.choices)


def _motion_rows(frame: MotionFrame) -> Iterator[tuple[str, ...]]:
    for code, forms in frame.words.items():
        if code in EMERGENCY:
            yield f"`{code}`", "", f"the character {EMERGENCY[code]}"
            continue
        parts = [p for p in forms[-1] if not isinstance(p, Sep)]
        units = dict.fromkeys(unit(frame.name, p.name) for p in parts)
        bounds = ", ".join(f"{p.name} {_choices(p)}" for p in parts)
        yield f"`{code}`", " ".join(units), bounds


# --- examples, tolerances, errata ----------------------------------------------------------------


def _robot_commands() -> Iterator[str]:
    rows = []
    for row in COMMANDS:
        names = ", ".join(f"{item.name} {_range(item.low, item.high)}" for item in row.items)
        where = ", ".join(f"{4 + item.at}..{3 + item.at + item.size}" for item in row.items)
        rows.append((str(row.address), f"{row.command:02X}", row.name, names, where))
    yield from table(("address", "command", "", "values", "offset"), rows)
    yield ""


def _examples(frame: FrameType) -> Iterator[str]:
    for example in examples():
        if example.type != frame.name:
            continue
        values = {k: v for k, v in frame.decode(example.raw).items() if v != []}
        yield "```text"
        yield from _shown(example.raw)
        yield from _wrapped(f"{name}={_value(value)}" for name, value in values.items())
        yield "```"
        yield ""


def _shown(raw: bytes) -> Iterator[str]:
    if all(0x20 <= byte < 0x7F for byte in raw):
        text = raw.decode("ascii")
        yield from (text[at : at + WIDTH] for at in range(0, len(text), WIDTH))
    else:
        yield from (raw[at : at + 24].hex(" ").upper() for at in range(0, len(raw), 24))


def _value(value: object) -> str:
    if isinstance(value, str):
        return value.encode("unicode_escape").decode("ascii")
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _wrapped(words: Iterable[str]) -> Iterator[str]:
    line = "->"
    for word in words:
        if len(line) + len(word) >= WIDTH:
            yield line
            line = "  "
        line += " " + word
    if line.strip("- >"):
        yield line


def _tolerances() -> Iterator[str]:
    yield "## Tolerances"
    yield ""
    yield "Set in the vehicle file or by `--option NAME=VALUE`; the first value is the default."
    yield ""
    rows = [
        (f"`{row.name}`", _some(row.values) or "an identifier", row.meaning) for row in TOLERANCES
    ]
    yield from table(("name", "values", "what is accepted besides"), rows)
    yield ""


def _keys() -> Iterator[str]:
    yield "## Keys of the vehicle file"
    yield ""
    yield "What a document leaves open or a board changes, in the table `wire` of the vehicle file;"
    yield "the default is the document's."
    yield ""
    rows = [
        (row.name, f"`{key.name}`", _default(key), key.allowed, key.meaning)
        for row in VEHICLES.values()
        for key in row.keys
    ]
    yield from table(("codec", "key", "default", "allowed", "means"), rows)
    yield ""


def _default(key: Key | Octets) -> str:
    return f"{key.default:.9g}" if isinstance(key, Key) else key.default


def _some(values: Sequence[str]) -> str:
    more = f", ... ({len(values)})" if len(values) > 4 else ""
    return ", ".join(values[:4]) + more


def _errata() -> Iterator[str]:
    yield "## Errata"
    yield ""
    yield "Where a document contradicts itself or is silent, and what is read here."
    yield ""
    rows = [
        (
            row.name,
            row.finding,
            row.reading,
            ", ".join(f"`{t}`" for t in row.tolerance.split(", ") if t),
        )
        for row in ERRATA
    ]
    yield from table(("", "found", "read as", "tolerance or key"), rows)
    yield ""


def _faults() -> Iterator[str]:
    yield "## Faults"
    yield ""
    yield "Bytes that belong to no accepted frame form runs, as long as can be. A run is one fault:"
    yield "its offset, its length, and the kind of its first candidate:"
    yield ", ".join(f"`{kind.value}`" for kind in FaultKind) + "."


if __name__ == "__main__":
    import sys

    sys.stdout.write(reference())
