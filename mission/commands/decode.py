"""``auvmission decode``: decode the bytes of a link, for people or for programs.

A table has one block per frame (offset in the stream; offset in the frame, name, value, unit) and
one line per fault. ``--json`` has one object per line, ``{"offset", "type", "values"}`` or
``{"offset", "fault", "length"}``; ``--hex-lines`` answers every line with a JSON array.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, BinaryIO

import click

if TYPE_CHECKING:
    from collections.abc import Iterator

    from protocol.framing import Frame, Framer, LinkRow
    from protocol.messages import FrameFault
    from protocol.tolerances import Tolerances

CHUNK = 1 << 16


def parse_options(pairs: tuple[str, ...]) -> Tolerances:
    """Parse the ``name=value`` of ``--option``; a bare name means ``on``."""
    from protocol.tolerances import Tolerances, UnknownTolerance

    options = {pair.partition("=")[0]: pair.partition("=")[2] or "on" for pair in pairs}
    try:
        return Tolerances.parse(options)
    except UnknownTolerance as error:
        raise click.BadParameter(str(error), param_hint="--option") from None


def link_row(name: str) -> LinkRow:
    from protocol.vehicles import UnknownVehicle, link

    try:
        return link(name)
    except UnknownVehicle as error:
        raise click.BadParameter(str(error), param_hint="--link") from None


@click.command(name="decode")
@click.option(
    "--link",
    "link_name",
    required=True,
    metavar="NAME",
    help="Where the bytes come from, e.g. auv.from_stm32; docs/protocol.md lists all.",
)
@click.option("--option", "options", multiple=True, metavar="K=V", help="A tolerance, by name.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object per line.")
@click.option("--hex", "as_hex", is_flag=True, help="The input is hexadecimal text.")
@click.option("--hex-lines", is_flag=True, help="Each line is a stream of its own, in hexadecimal.")
@click.argument("file", type=click.File("rb"), default="-")
def decode(
    link_name: str,
    options: tuple[str, ...],
    as_json: bool,
    as_hex: bool,
    hex_lines: bool,
    file: BinaryIO,
) -> None:
    """Show the frames and the faults in FILE (- is standard input).

    CAN frames are written as ID#DATA, one per line.
    """
    import json

    row, tolerances = link_row(link_name), parse_options(options)
    if hex_lines:
        for number, line in enumerate(file, 1):
            found = _stream(row.framer(tolerances), [_line_bytes(row, line, number)])
            click.echo(json.dumps([as_object(item) for item in found]))
        return
    framer = row.framer(tolerances)
    for item in _items(row, framer, file, as_hex):
        click.echo(json.dumps(as_object(item)) if as_json else as_block(item))
    if not as_json:
        click.echo(summary(framer))


def _items(
    row: LinkRow, framer: Framer, file: BinaryIO, as_hex: bool
) -> Iterator[Frame | FrameFault]:
    if row.line is not None:
        for number, line in enumerate(file, 1):
            yield from _stream(framer, [_line_bytes(row, line, number)])
    elif as_hex:
        lines = enumerate(file, 1)
        yield from _stream(framer, (_line_bytes(row, line, number) for number, line in lines))
    else:
        yield from _stream(framer, iter(lambda: file.read(CHUNK), b""))


def _stream(framer: Framer, chunks: Any) -> Iterator[Frame | FrameFault]:
    """Decode all chunks, and then an idle time, which gives up an unfinished frame."""
    for chunk in chunks:
        yield from framer.receive(chunk, 0.0)
    yield from framer.flush(float("inf"))


def _line_bytes(row: LinkRow, line: bytes, number: int) -> bytes:
    text = line.decode("ascii", "replace").strip()
    try:
        if row.line is not None:
            return row.line(text) if text else b""
        return bytes.fromhex(text)
    except ValueError as error:
        shown = repr(text[:60])
        kind = (
            f"not hexadecimal: {shown}; write bytes of two digits each"
            if row.line is None
            else f"no CAN frame ID#DATA: {shown} ({error})"
        )
        raise click.UsageError(f"line {number}: {kind}") from None


# --- forms of output ---


def as_object(item: Frame | FrameFault) -> dict[str, object]:
    from protocol.messages import FrameFault

    if isinstance(item, FrameFault):
        return {"offset": item.offset, "fault": item.kind, "length": item.length}
    return {"offset": item.offset, "type": item.type.name, "values": item.values()}


def as_block(item: Frame | FrameFault) -> str:
    from protocol.messages import FrameFault
    from protocol.units import unit

    if isinstance(item, FrameFault):
        return f"{item.offset:>8}  FAULT {item.kind}, {item.length} bytes"
    values = item.values()
    flags = values.pop("flags", [])
    inside = _offsets(item)
    lines = [f"{item.offset:>8}  {item.type.name}, {len(item.raw)} bytes  ({item.type.title})"]
    for name, value in values.items():
        at = f"+{inside[name]}" if name in inside else ""
        measured = unit(item.type.name, name)
        lines.append(f"          {at:>5}  {name:<20} {_shown(value):>16} {measured}".rstrip())
    lines += [f"                 doubtful: {flag}" for flag in flags]
    return "\n".join(lines)


def _offsets(frame: Frame) -> dict[str, int]:
    from protocol.fields import BinaryFrame

    table = frame.type
    if not isinstance(table, BinaryFrame):
        return {}
    pairs = zip(table.fields, table.offsets, strict=True)
    return {name: at for field, at in pairs if (name := getattr(field, "name", ""))}


def _shown(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, str):
        return value.encode("unicode_escape").decode("ascii")
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def summary(framer: Framer) -> str:
    counters = framer.counters
    faults = ", ".join(f"{count} {kind}" for kind, count in sorted(counters.bad.items()))
    return f"{counters.good} frames; faults: {faults or 'none'}; {counters.skipped} bytes skipped"
