"""``auvmission encode``: make one frame from its values, by the names of docs/protocol.md."""

from __future__ import annotations

import click


@click.command(name="encode")
@click.argument("frame_type", metavar="TYPE")
@click.argument("values", metavar="JSON", default="{}")
@click.option("--hex", "as_hex", is_flag=True, help="Print hexadecimal text, not raw bytes.")
@click.option("--option", "options", multiple=True, metavar="K=V", help="A tolerance, by name.")
def encode(frame_type: str, values: str, as_hex: bool, options: tuple[str, ...]) -> None:
    """Print the frame of TYPE (auv.SD, ...) with the values of the object JSON."""
    import json

    from mission.commands.decode import parse_options
    from protocol.codec import CannotEncode
    from protocol.vehicles import frame_types

    types = frame_types(parse_options(options))
    if frame_type not in types:
        raise click.BadParameter(f"no type {frame_type!r}; there are: {', '.join(sorted(types))}")
    try:
        given = json.loads(values)
    except json.JSONDecodeError as error:
        raise click.BadParameter(f"no JSON: {error}", param_hint="JSON") from None
    if not isinstance(given, dict):
        raise click.BadParameter(f"an object is needed, not {values[:60]}", param_hint="JSON")
    try:
        frame = types[frame_type].encode(given)
    except CannotEncode as error:
        raise click.BadParameter(str(error), param_hint="JSON") from None
    carried = types[frame_type].decode(frame)
    if idle := [name for name in given if name not in carried and name != "flags"]:
        why = f"{frame_type}: nothing in this frame is called {', '.join(idle)}"
        there = f"its values are {', '.join(carried) or 'none'}"
        raise click.BadParameter(f"{why}; {there}", param_hint="JSON")
    click.echo(frame.hex() if as_hex else frame, nl=as_hex)
