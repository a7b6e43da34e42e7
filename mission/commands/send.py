"""``auvmission send``: any command of document 000 to a vehicle, any frame to a free port."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mission.commands.operator import TO
from mission.commands.options import AS_JSON, LinkUrl

if TYPE_CHECKING:
    from mission.onboard.configuration import Configuration


ANSWER_S = 1.0


@click.command()
@click.argument("word", required=False)
@click.argument("values", nargs=-1, metavar="[NAME=VALUE]...")
@TO
@AS_JSON
@click.option("--list", "listed", is_flag=True, help="Show every word with an example.")
@click.option("--port", type=LinkUrl(), metavar="URL",
              help="Instead of --to: a board's own port; no serve has it.")  # fmt: skip
@click.option("--text", help="With --port: these characters as they are, e.g. '@RI$'.")
@click.option("--hex", "as_hex", metavar="HEX", help="With --port: these bytes; on CAN ID#DATA.")
@click.option("--every", type=click.FloatRange(min=0.01), default=0.1, show_default=True,
              metavar="SECONDS", help="With --port and --for: again so often.")  # fmt: skip
@click.option("--for", "seconds", type=click.FloatRange(min=0.0), default=0.0, metavar="SECONDS",
              help="With --port: say it again for so long; boards go neutral without.")  # fmt: skip
@click.option("--link", "link_name", metavar="NAME",
              help="With --port: show what comes back for a second, as listen does.")  # fmt: skip
@click.option("-c", "--config", type=click.Path(path_type=Path),
              help="As for serve: whose ports may be taken.")  # fmt: skip
def send(
    word: str | None,
    values: tuple[str, ...],
    to: str,
    as_json: bool,
    listed: bool,
    port: str | None,
    text: str | None,
    as_hex: str | None,
    every: float,
    seconds: float,
    link_name: str | None,
    config: Path | None,
) -> None:
    """Send a command of document 000 to the vehicle, and print its answer.

    WORD is SP, NS, MM and so on; its values have the names of docs/protocol.md. Values that no
    vehicle accepts are refused here. If the vehicle refuses, its reason is printed. Exit 0 if it is
    acknowledged, or, for commands without acknowledgement, if the Pi has it; 1 if it is refused or
    not answered.

    With --port a frame of any document (rov.DOWN, ...), or raw bytes, are sent directly to a board:
    for tests on deck. No program watches then, and only the board itself can stop something.
    """
    from mission.commands.words import say_word

    if listed:
        _list()
        return
    if port is None:
        if word is None or text is not None or as_hex is not None:
            raise click.UsageError("name a WORD (--list shows all); bytes need --port")
        say_word(to, _word(word), _values(word, values), as_json)
        return
    data = _bytes(port, word, _values(word, values), text, as_hex)
    _refuse_held(port, config)
    _speak(_with_baud(port, link_name or word), data, (every, seconds), link_name, as_json)


def _word(name: str) -> str:
    return name.removeprefix("auv.").removeprefix("@").upper()


def _list() -> None:
    from mission.topside.words import frame_types
    from protocol.examples import examples

    types = frame_types()
    for example in examples():
        name = example.type.removeprefix("auv.")
        is_word = example.type.startswith("auv.") and name in types
        if is_word and types[name].check(example.raw) is None:
            values = types[name].decode(example.raw)
            shown = [f"{k}={v}" for k, v in values.items() if k not in ("flags", "effective")]
            click.echo(" ".join([f"{name:4}", *shown]))


def _values(word: str | None, pairs: tuple[str, ...]) -> dict[str, Any]:
    """Parse NAME=VALUE pairs: JSON values, else text. Text fields of the frame stay text."""
    found, texts = dict[str, Any](), _texts(word)
    for pair in pairs:
        name, equals, value = pair.partition("=")
        if not equals:
            raise click.UsageError(f"{pair!r}: write NAME=VALUE")
        try:
            is_plain = name in texts and not value.startswith('"')
            found[name] = value if is_plain else json.loads(value)
        except json.JSONDecodeError:
            found[name] = value
    return found


def _texts(word: str | None) -> set[str]:
    """The names of a frame's values that are text: letters, hexadecimal, times."""
    from protocol.examples import examples
    from protocol.vehicles import frame_types

    types, name = frame_types(), _full_name(word or "")
    shown = [types[name].decode(e.raw) for e in examples() if e.type == name]
    return {key for values in shown for key, value in values.items() if isinstance(value, str)}


def _full_name(word: str) -> str:
    from protocol.vehicles import frame_types

    return word if word in frame_types() else f"auv.{_word(word)}"


# --- straight to a board -------------------------------------------------------------------------


def _bytes(
    port: str, word: str | None, values: dict[str, Any], text: str | None, as_hex: str | None
) -> bytes:
    if (word, text, as_hex).count(None) != 2:
        raise click.UsageError("one of WORD, --text and --hex is needed")
    if text is not None:
        return text.encode("ascii", "replace")
    if as_hex is not None:
        return _from_hex(port, as_hex)
    assert word is not None
    return _frame(word, values)


def _from_hex(port: str, text: str) -> bytes:
    from protocol.vehicles.motorcan import from_line

    try:
        if port.startswith("can://"):
            return from_line(text)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--hex") from None
    try:
        return bytes.fromhex(text)
    except ValueError:
        why = f"{text!r}: write bytes of two hexadecimal digits each, for instance 40524924"
        raise click.BadParameter(why, param_hint="--hex") from None


def _frame(word: str, values: dict[str, Any]) -> bytes:
    from protocol.codec import CannotEncode
    from protocol.vehicles import frame_types
    from protocol.vehicles.motorcan import CanFrame

    types = frame_types()
    name = _full_name(word)
    if name not in types:
        raise click.UsageError(f"no frame {word!r}; there are: {', '.join(sorted(types))}")
    frame = types[name]
    try:
        raw = frame.encode(values)
    except CannotEncode as error:
        raise click.UsageError(str(error)) from None
    carried = frame.decode(raw)
    if idle := [one for one in values if one not in carried]:
        known = ", ".join(one for one in carried if one != "flags")
        raise click.UsageError(f"{name} has no {', '.join(idle)}; its values are: {known}")
    return frame.record(values) if isinstance(frame, CanFrame) else raw


def _with_baud(port: str, of: str | None) -> str:
    """The URL with the baud rate of the link or frame ``of``, if one is named."""
    from links.base import LinkError
    from mission.topside.hearing import with_baud

    try:
        return with_baud(port, of.lower() if of and "." in of else "auv.")
    except LinkError as error:
        raise click.BadParameter(str(error), param_hint="--port") from None


def _configuration(config: Path | None) -> Configuration:
    from mission.onboard.configuration import ConfigurationError, load_configuration

    try:
        return load_configuration(config)
    except ConfigurationError as error:
        click.echo(str(error), err=True)
        raise SystemExit(2) from None


def _refuse_held(port: str, config: Path | None) -> None:
    import time

    from mission.onboard.doctor.holder import holder

    held = holder(port, _configuration(config), time.time())
    if held is not None:
        says = f"{port}: serve (process {held.process}) has it: say it with --to, or stop serve"
        click.echo(says, err=True)
        raise SystemExit(1)


def _speak(
    url: str, data: bytes, repeat: tuple[float, float], link_name: str | None, as_json: bool
) -> None:
    """Send ``data``. ``repeat``: every so many s, for so many s."""
    from links.base import LinkError
    from mission.commands.decode import link_row
    from mission.topside import hearing
    from mission.topside.console import speak
    from protocol.tolerances import Tolerances

    ear = None if link_name is None else hearing.Hearing(link_row(link_name), Tolerances())
    form = hearing.as_json if as_json else hearing.as_line
    try:
        for rx in speak(url, data, repeat, ANSWER_S if ear else 0.0):
            for heard in ear.receive(rx) if ear else ():
                click.echo(form(heard, False))
    except LinkError as error:
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
    text = data.decode("ascii", "replace")
    click.echo(
        f"sent: {text if data.isascii() and text.isprintable() else data.hex(' ')}", err=True
    )
