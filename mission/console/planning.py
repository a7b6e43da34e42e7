"""Requests of the page's plan beside the check: edits of the chart, words, differences, imports.

text, an edit --authoring.editing--> text          text, what is on board --diff--> changes
a file of another program --authoring.importing--> text, and what was left out
"""

from __future__ import annotations

import base64
import difflib
import math
from collections.abc import Sequence
from pathlib import Path, PurePath
from typing import Any

from mission.authoring.diff import compare
from mission.authoring.diff.show import as_object
from mission.authoring.editing.edits import add, move, remove
from mission.authoring.editing.layout import EditError
from mission.authoring.importing import ImportErrors
from mission.authoring.importing.taking import taken
from mission.authoring.importing.writing import Answers
from mission.authoring.language import script
from mission.authoring.language.assembly import DEFAULT_VEHICLE
from mission.authoring.language.vocabulary import vocabulary
from mission.authoring.prepare import Prepared, Unreadable, prepare_text
from mission.console.asked import Refused, Said, worked
from mission.model import Position
from mission.model.extent import BYTES
from mission.model.shipped import load_vehicle
from mission.model.vehicle import VehicleError

IMPORT = BYTES.most * 4 // 3 + 4096  # bytes of a file in base64, and of the other fields
IMPORT_NEEDS = "an import needs the file's name, and its data as base64"
EDIT_NEEDS = "an edit needs text, source, do, the place's number at, and to: [latitude, longitude]"


async def words() -> list[dict[str, str]]:
    return await worked(vocabulary)


async def edited(said: Said) -> dict[str, str]:
    """Return the text with one edit. Raises Refused."""
    text, source, do = str(said["text"]), str(said["source"]), said["do"]
    at = said.get("at")
    if at is not None and not isinstance(at, int):
        raise TypeError(at)
    try:
        if do == "move":
            made = await worked(move, text, source, int(said["at"]), _place(said["to"]))
        elif do == "remove":
            made = await worked(remove, text, source, int(said["at"]))
        elif do == "add":
            what = str(said["what"])
            made = await worked(add, text, source, what, _place(said["to"]), at)
        else:
            raise Refused("an edit is move, add or remove")
    except EditError as error:
        raise Refused(str(error)) from None
    return {"text": made}


def _place(said: Any) -> tuple[float, float]:
    latitude, longitude = said
    found = float(latitude), float(longitude)
    if not all(map(math.isfinite, found)):
        raise ValueError("no place")
    return found


# --- against what is on board ---------------------------------------------------------------------


def difference(text: str, source: str, board: str, vehicle: str | None) -> dict[str, Any]:
    """``board``: the text of the mission on board. Raises Refused."""
    before = _prepared(board, "on board", vehicle, "what is on board cannot be read here")
    after = _prepared(text, source, vehicle, "mend the text first")
    found = compare(before, after)
    return {**as_object(found), "rows": _rows(script(before.mission), script(after.mission))}


def _prepared(text: str, source: str, vehicle: str | None, else_says: str) -> Prepared:
    try:
        return prepare_text(text, source, vehicle)
    except Unreadable as error:
        raise Refused(f"{else_says}: {error.diagnostics[0].brief}") from None


def _rows(before: Sequence[str], after: Sequence[str]) -> list[list[str]]:
    """Return ``[mark, line]`` of both missions, as the vehicle stores them: " " both, "-" on board,
    "+" here."""
    old, new = before[1:], after[1:]  # without the first line, which has the sum
    rows = list[list[str]]()
    for what, a, b, c, d in difflib.SequenceMatcher(None, old, new).get_opcodes():
        if what == "equal":
            rows += [[" ", line] for line in old[a:b]]
        else:
            rows += [*(["-", line] for line in old[a:b]), *(["+", line] for line in new[c:d])]
    return rows


# --- files of other programs ----------------------------------------------------------------------


async def imported(said: Said, vehicle: str | None) -> dict[str, Any]:
    """Raises Refused with what is wrong, and which answer would help."""
    data = base64.b64decode(str(said["data"]), validate=True)
    name = PurePath(str(said["name"])).name
    answers, pick = _answers(said), said.get("pick")
    pick = None if pick is None else str(pick)
    try:
        boat = load_vehicle(vehicle or DEFAULT_VEHICLE)
        found = await worked(taken, Path(name), data, answers, pick, boat)
    except (ImportErrors, VehicleError) as error:
        raise Refused(str(error)) from None
    return {"text": found.text, "source": f"{found.name}.yaml", "left_out": list(found.left_out)}


def _answers(said: Said) -> Answers:
    home = said.get("home")
    first = home == "first"
    place = None if home is None or first else Position(*_place(home))
    depth = said.get("depth")
    gear = said.get("gear")
    return Answers(
        place,
        first,
        bool(said.get("swap")),
        None if depth is None else float(depth),
        None,
        None if gear is None else int(gear),
    )
