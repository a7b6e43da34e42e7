"""The commands that a page can send ("intents"), one row each; every answer says what became of it.

    {"id", "at", "do", ...} --too old, unknown--> refused
                            --row--> a conversation with the vehicle --> acknowledged | refused |
                                                                         unanswered

The page sends the time of the press: an intent older than ``FRESH_S`` no longer counts. X and W are
not here (orders).
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from mission.authoring.check import Proved
from mission.authoring.language import script
from mission.authoring.prepare import Prepared, Unreadable, check_prepared, prepare_text
from mission.console import plans
from mission.console.line import NotSent
from mission.console.vehicle import Vehicle
from mission.model.diagnostics import Diagnostic
from mission.topside.overdue import plan_of
from mission.topside.underwater import BatchTalk
from mission.topside.upload import (
    OperatorError,
    Refused,
    Script,
    clear,
    start_telling,
    upload,
)
from mission.topside.words import command, say
from protocol.codec import CannotEncode

FRESH_S = 0.5
Said = Mapping[str, Any]
Told = Callable[..., None]
"""``told(is_now, says, **more)``."""


class Malformed(ValueError):
    """A message that no page sends."""


@dataclass(frozen=True, slots=True)
class Asked:
    vehicle: Vehicle
    said: Said
    told: Told

    def text(self, name: str) -> str:
        value = self.said.get(name)
        if not isinstance(value, str):
            raise Malformed(f"{self.said['do']} needs the text {name}")
        return value


async def obey(vehicle: Vehicle, said: Said, told: Told) -> None:
    """Carry out an intent. ``told`` gets its states. Raises Malformed."""
    row = DO.get(str(said.get("do")))
    at = said.get("at")
    if row is None or not isinstance(at, int | float):
        raise Malformed(f"an intent has do, one of {', '.join(DO)}, and at")
    is_now, says = "refused", _too_old(float(at))
    if not says:
        try:
            is_now, says = "acknowledged", await row(Asked(vehicle, said, told))
        except (Refused, NotSent, CannotEncode) as why:
            says = str(why)
        except OperatorError as why:
            is_now, says = "unanswered", str(why)
    vehicle.log.note(vehicle.given.name, **_logged(said), became=is_now, says=says)
    told(is_now, says)


def _too_old(at: float) -> str:
    age = time.time() - at
    if age > FRESH_S:
        return f"it came {age:.1f} s after the press: press again if you still mean it"
    if age < -FRESH_S:
        return f"the page's clock is {-age:.1f} s ahead of the console's"
    return ""


def _logged(said: Said) -> dict[str, Any]:
    return {name: value for name, value in said.items() if name not in ("id", "text")}


def _demand_idle(asked: Asked) -> None:
    """Raises Refused."""
    if asked.vehicle.commands.is_busy:
        raise Refused("something else is under way: wait for its end")


async def _say(asked: Asked, what: Script) -> str:
    _demand_idle(asked)
    asked.told("sent", "")
    return await asked.vehicle.commands.say(what)


async def _start(asked: Asked) -> str:
    digest, may_dive = asked.text("digest")[:16], list[str]()
    try:
        return await _say(asked, start_telling(may_dive.append, named=digest))
    finally:
        for started in may_dive:
            await asyncio.to_thread(asked.vehicle.contacts.started, started)


async def _clear(asked: Asked) -> str:
    return await _say(asked, clear())


async def _word(asked: Asked) -> str:
    values = asked.said.get("values")
    if not isinstance(values, dict):
        raise Malformed("say needs values")
    under_water = asked.vehicle.under_water
    said = command(asked.text("word"), values)
    return await _say(asked, say(said, under_water=under_water))


async def _take(asked: Asked) -> str:
    """Take the command with a frame that changes nothing: @SP without any limit."""
    await _say(asked, say(command("SP", {}), under_water=asked.vehicle.under_water))
    return "the command is taken"


async def _leave(asked: Asked) -> str:
    if asked.vehicle.under_water:
        raise Refused("by modem there is one connection: it is let go of by 10 s of silence")
    _demand_idle(asked)
    await asked.vehicle.commands.renew()
    return "the command is free"


async def _check(asked: Asked) -> str:
    point, vehicle = asked.text("point"), asked.vehicle
    if point not in vehicle.given.checklist:
        raise Refused(f"the checklist has no point {point!r}")
    if asked.said.get("done"):
        vehicle.checked = {**vehicle.checked, point: time.time()}
    else:
        vehicle.checked = {p: t for p, t in vehicle.checked.items() if p != point}
    return point


async def _upload(asked: Asked) -> str:
    vehicle, text, source = asked.vehicle, asked.text("text"), asked.text("source")
    prepared, proved = await asyncio.to_thread(_judged, text, source, vehicle.given.vehicle)
    lines, digest, line = script(prepared.mission), prepared.chart.digest, vehicle.commands
    _demand_idle(asked)

    def progress(have: int, of: int) -> None:
        asked.told("progress", "", have=have, of=of)

    asked.told("sent", "")
    line.is_uploading = True
    try:
        if line.acoustics is not None:
            achieved = await line.hold(BatchTalk(lines, digest, line.acoustics, progress))
        else:
            achieved = await line.say(upload(lines, digest, progress))
    finally:
        line.is_uploading = False
    vehicle.uploaded(await asyncio.to_thread(plans.shown, prepared))
    remember = vehicle.contacts.dives.uploaded
    await asyncio.to_thread(remember, digest, plan_of(prepared, proved))
    return achieved


def _judged(text: str, source: str, vehicle: str | None) -> tuple[Prepared, Proved]:
    """Raises Refused with the check's findings."""
    try:
        prepared = prepare_text(text, source, vehicle)
    except Unreadable as error:
        raise Refused(_brief(error.diagnostics)) from None
    report = check_prepared(prepared)
    if not report.ok or report.proved is None:
        raise Refused(_brief(report.refusals))
    return prepared, report.proved


def _brief(found: tuple[Diagnostic, ...]) -> str:
    more = f"; and {len(found) - 1} more" if len(found) > 1 else ""
    return f"the check refuses it: {found[0].brief}{more}"


DO: Mapping[str, Callable[[Asked], Awaitable[str]]] = MappingProxyType(
    {
        "start": _start,
        "clear": _clear,
        "upload": _upload,
        "say": _word,
        "take": _take,
        "leave": _leave,
        "check": _check,
    }
)
