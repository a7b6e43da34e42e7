"""The acknowledgement ``@ACK_``: the result of a command, or a mask of nodes or sensors.

What does not live here: the operator's commands, whose rows have the result letters
(``protocol.operator_words``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values, required
from protocol.operator_words import WORDS
from protocol.tolerances import Tolerances
from protocol.topside_frames import ALWAYS_ON, SENSORS, letters_of


class AckFrame(FrameType):
    """``@ACK_`` class function result ``$``, 9 bytes by length (000 tables 2.1.1 and 3.1).

    The result is a letter or, for NI and RI, a raw mask byte. For Z the letter is Y or N, for the
    other commands their own letter for done (as A in ``@ACK_AAA$``) or N for refused.
    """

    name, title, lead, length = "auv.ACK", "000 tables 2.1.1 and 3.1", b"@ACK_", 9
    Z_CODES = "FBLRUDSEHAVXW"

    def __init__(self, groups: str, tolerances: Tolerances, z_codes: str = Z_CODES) -> None:
        """``groups``: the classes that this link carries, of N A S R Z. ``z_codes``: the Z codes
        that it acknowledges."""
        rs = "SYN" if tolerances.on("rs_yn") else "S"
        table = {word.code: word.letter + "N" for word in WORDS.values() if word.letter}
        table |= {"RS": rs}
        table |= {"Z" + code: "YN" for code in z_codes}
        self._letters = {k: v for k, v in table.items() if k[0] in groups}
        self._masks = {k: n for k, n in {"NI": 6, "RI": 7}.items() if k[0] in groups}

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        return self.length if end - at >= self.length else 0

    def check(self, raw: bytes) -> FaultKind | None:
        if raw[8] != 0x24:
            return FaultKind.BAD_TAIL
        code = raw[5:7].decode("latin-1")
        if code in self._masks or chr(raw[7]) in self._letters.get(code, ""):
            return None
        return FaultKind.BAD_ENUM

    def decode(self, raw: bytes) -> Values:
        code = raw[5:7].decode("ascii")
        values: Values = {"class": code[0], "func": code[1]}
        if code in self._masks:
            return values | self._mask(code, raw[7])
        values["ok"] = raw[7] != ord("N")
        if code[0] == "Z":
            values["code"] = code[1]
        values["flags"] = []
        return values

    def _mask(self, code: str, mask: int) -> Values:
        count = self._masks[code]
        flags = ["mask:out_of_range"] if mask >> count else []
        if code == "RI":
            flags += [f"{SENSORS[bit]}:off" for bit in ALWAYS_ON if not mask >> bit & 1]
        named = "nodes" if code == "NI" else "sensors"
        return {"mask": mask, named: letters_of(mask, count), "flags": flags}

    def encode(self, values: Mapping[str, Any]) -> bytes:
        code = "".join(str(required(values, key, self.name)) for key in ("class", "func"))
        if code in self._masks:
            result = required(values, "mask", self.name)
            if not isinstance(result, int) or not 0 <= result <= 255:
                raise CannotEncode(f"{self.name}: mask is a byte, not {result!r}")
        else:
            letters = self._letters.get(code)
            if letters is None:
                known = ", ".join((*self._letters, *self._masks))
                raise CannotEncode(f"{self.name}: class and func are one of {known}, not {code!r}")
            result = ord(letters[0] if required(values, "ok", self.name) else "N")
            if chr(result) not in letters:
                raise CannotEncode(f"{self.name}: {code} has no negative answer")
        return self.lead + code.encode("ascii") + bytes([result]) + b"$"
