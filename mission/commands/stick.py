"""``auvmission stick``: steer the vehicle manually, with the keyboard or a joystick."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

import click

from mission.commands.operator import TO

if TYPE_CHECKING:
    from mission.topside.joystick import Joystick
    from mission.topside.keyboard import Switch, Switches

KEYS = """arrows: ahead, back, to port, to starboard    PgUp PgDn, or r f: up, down
+ - 1..9: how strong    space: let go    x: stop everything    q: end"""


@click.command()
@TO
@click.option("--gear", type=click.IntRange(1, 12), default=3, show_default=True,
              help="How strong a full push is, of 12.")  # fmt: skip
@click.option("--pad", type=click.Path(path_type=Path), metavar="DEVICE",
              help="A joystick beside the keys, e.g. /dev/input/js0.")  # fmt: skip
@click.option("--axes", type=(int, int, int), default=(0, 1, 4), show_default=True,
              help="The pad's axes: to starboard, back, down.")  # fmt: skip
@click.option("--dead-man", type=int, default=4, show_default=True,
              help="The pad's button that has to be held.")  # fmt: skip
@click.option("--output", "outputs", multiple=True, metavar="KEY=NAME:VALUE[/OFF]",
              help="A letter that sets an output of the vehicle file, e.g. l=lamp:80; with /OFF "
                   "while it is held, e.g. s=side:7/0; repeatable.")  # fmt: skip
def stick(
    to: str,
    gear: int,
    pad: Path | None,
    axes: tuple[int, int, int],
    dead_man: int,
    outputs: tuple[str, ...],
) -> None:
    """Steer the vehicle manually, with this terminal's keys or a joystick (M, every 200 ms).

    Hold a key to move. A key counts for 0.75 s, and longer while it repeats. On a pad the dead
    man's button has to be held. If terminal, pad or link is lost, a vehicle that was moved is
    stopped within 2 s; one that was sent nothing continues. X is sent every second until it is
    acknowledged. In an emergency let go for 2 s, then push.

    Outputs that move or hold the vehicle beside its setpoint (--output) can be set here, or by
    legs.

    One line shows what is sent and what is answered. Exit 0 if you ended it, 1 if something is
    lost.
    """
    from mission.topside.keyboard import Keyboard
    from mission.topside.stick import Stick
    from mission.topside.underwater import PREFIX
    from mission.topside.upload import OperatorError

    if to.startswith(PREFIX):
        raise click.UsageError("the stick does not work by modem (R6)")
    switches = _switches(outputs)
    told = [f"{key.decode()}: {', '.join(map(_said, own))}" for key, own in switches.items()]
    click.echo("\n".join([KEYS, *told]), err=True)
    shown = _Line()
    try:
        with _terminal() as keys, _opened(pad) as fd:
            reader = None if fd is None else (fd, _joystick(axes, dead_man, gear))
            Stick(keys, Keyboard(gear, switches), shown.show, reader).steer(to)
    except OperatorError as error:
        shown.end()
        click.echo(str(error), err=True)
        raise SystemExit(1) from None
    shown.end()


def _switches(outputs: tuple[str, ...]) -> Switches:
    import re

    from mission.topside.keyboard import Switch, is_free

    found: dict[bytes, tuple[Switch, ...]] = {}
    number = r"(-?\d+(?:\.\d+)?)"
    for text in outputs:
        parts = re.fullmatch(rf"(.)=(\w+):{number}(?:/{number})?", text, re.ASCII)
        if parts is None:
            raise click.BadParameter(f"{text!r}: write e.g. l=lamp:80 or s=side:7/0")
        key = parts[1].encode()
        if not is_free(key):
            raise click.BadParameter(f"{text!r}: {parts[1]!r} is no letter, or the stick's own")
        otherwise = None if parts[4] is None else float(parts[4])
        found[key] = (*found.get(key, ()), Switch(parts[2], float(parts[3]), otherwise))
    return found


def _said(switch: Switch) -> str:
    held = "" if switch.otherwise is None else f" while held, else {switch.otherwise:g}"
    return f"{switch.name} {switch.value:g}{held}"


def _joystick(axes: tuple[int, int, int], dead_man: int, gear: int) -> Joystick:
    from mission.topside.helm import GEARS
    from mission.topside.joystick import Joystick, Layout

    turn, surge, heave = axes
    return Joystick(Layout(turn, surge, heave, dead_man), gear / GEARS)


@contextmanager
def _terminal() -> Iterator[int]:
    """Yield the terminal's descriptor in cbreak mode; restore its mode afterwards."""
    import termios
    import tty

    fd = sys.stdin.fileno()
    if not os.isatty(fd):
        raise click.UsageError("the stick needs a terminal")
    before = termios.tcgetattr(fd)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _leave)
    tty.setcbreak(fd)
    try:
        yield fd
    finally:
        with suppress(termios.error):  # the terminal may be gone
            termios.tcsetattr(fd, termios.TCSADRAIN, before)


def _leave(number: int, _: FrameType | None) -> NoReturn:
    """Exit through the end of all that is open, so that the last commands are still sent."""
    raise SystemExit(1)


@contextmanager
def _opened(pad: Path | None) -> Iterator[int | None]:
    if pad is None:
        yield None
        return
    try:
        fd = os.open(pad, os.O_RDONLY | os.O_NONBLOCK)
    except OSError as error:
        click.echo(f"{pad}: {error.strerror} (is the user in the group input?)", err=True)
        raise SystemExit(1) from None
    try:
        yield fd
    finally:
        os.close(fd)


class _Line:
    """One line, overwritten in a terminal; elsewhere nothing is printed."""

    def __init__(self) -> None:
        self._terminal, self._last = sys.stdout.isatty(), ""

    def show(self, text: str) -> None:
        import shutil

        if text == self._last:
            return
        self._last = text
        if self._terminal:
            width = shutil.get_terminal_size().columns - 1
            click.echo(f"\r\x1b[2K{text[:width]}", nl=False)

    def end(self) -> None:
        if self._terminal:
            click.echo()
