"""The Z class of document 000 (tables 2.2.1 and 2.2.2): the Pi's commands to the STM32.

    @ZA code value $        F B L R U D gear | S depth | E altitude | H heading | A pitch;roll | V
    @ZAX0$ @ZAWF$           stop all thrusters, emergency surfacing: also from topside (R7)

Headings are in the yaw convention: 0 north, +90 WEST. As built, H carries the speed as well
(``@ZAH-20,4$``); there is no other way to hold a heading while moving.

What does not live here: which commands bring which STM32 to a setpoint (``protocol.vehicles.auv``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, Values, required
from protocol.text import Int, Item, Refused, Sep, TextFrame, format_items, parse_items
from protocol.tolerances import Tolerances

GEARS = "FBLRUD"
EMERGENCY = {"X": "0", "W": "F"}  # fixed characters, nothing else (E-V15)
HEADING = Int("heading_deg", -180, 180)


def _words(separators: str, gear_behind: bool) -> dict[str, tuple[tuple[Item, ...], ...]]:
    """Return the forms of each code; ``format`` sends the first form that its values fill."""
    gear = Int("gear", 0, 12)
    words: dict[str, tuple[tuple[Item, ...], ...]] = dict.fromkeys(GEARS, ((gear,),))
    words["S"] = ((Int("depth_m", 0, 9999),),)
    words["E"] = ((Int("altitude_m", 0, 9999),),)
    words["H"] = ((HEADING,),)
    if gear_behind:
        words["H"] = ((HEADING, Sep(","), gear), (HEADING,))
    pitch, roll = Int("pitch_deg", -180, 180), Int("roll_deg", -90, 90)
    words["A"] = tuple((pitch, Sep(separator), roll) for separator in separators)
    words["V"] = ((Int("speed_mps", 0, 9999),),)
    return words


class MotionFrame(TextFrame):
    def __init__(self, tolerances: Tolerances, codes: str = "FBLRUDSEHAVXW") -> None:
        """``codes``: the Z codes that this link carries."""
        super().__init__("auv.ZA", "000 tables 2.2.1 and 2.2.2", "@ZA")
        separators = ",;" if tolerances.on("zaa_comma") else ";"
        words = _words(separators, tolerances.on("zah_gear"))
        self.words = {code: words.get(code, ()) for code in codes}

    def parse(self, body: str) -> Values:
        code, value = body[:1], body[1:]
        if not code:
            raise Refused(FaultKind.EMPTY_FIELD)
        if code not in self.words:
            raise Refused(FaultKind.BAD_ENUM)
        values: Values = {"code": code}
        if code in EMERGENCY:
            if value != EMERGENCY[code]:
                raise Refused(FaultKind.BAD_ENUM)
        else:
            values |= _first_form(self.words[code], value)
        values["flags"] = ["not_implementable"] if code == "V" else []
        return values

    def format(self, values: Mapping[str, Any]) -> str:
        code = required(values, "code", self.name)
        if not isinstance(code, str) or code not in self.words:
            raise CannotEncode(f"{self.name}: code is one of {''.join(self.words)}, not {code!r}")
        if code in EMERGENCY:
            return code + EMERGENCY[code]
        forms = self.words[code]
        fitting = (form for form in forms if all(n in values for n in _names(form)))
        return code + format_items(next(fitting, forms[-1]), values, self.name)


def _names(form: Sequence[Item]) -> list[str]:
    return [item.name for item in form if not isinstance(item, Sep)]


def _first_form(forms: Sequence[Sequence[Item]], text: str) -> Values:
    """Read ``text`` in the first form that fits. Raises Refused with the reason of the last form,
    which is the document's."""
    for form in forms[:-1]:
        try:
            return parse_items(form, text)
        except Refused:
            continue
    return parse_items(forms[-1], text)


AS_BUILT = Tolerances({"zah_gear": "on", "zaa_comma": "on"})


def parse_z(frame: bytes, tolerances: Tolerances | None = None) -> Values:
    """Return the values of one ``@ZA..$``. Raises Refused with the kind of fault."""
    table = MotionFrame(tolerances or Tolerances())
    if not frame.startswith(table.lead):
        raise Refused(FaultKind.BAD_HEADER)
    if not frame.endswith(b"$"):
        raise Refused(FaultKind.BAD_TAIL)
    return table.parse(table.body(frame))
