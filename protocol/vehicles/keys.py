"""The keys of a vehicle's ``wire`` table: values that its document leaves open or a board changes.

    wire: {surge_g: 8000, ins_on: 0}        # in place of the defaults, which are the document's

A row of VEHICLES has its keys. An unknown name or a value outside its range is refused before any
byte is written. What does not live here: other readings of the bytes (protocol.tolerances).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


class UnknownKey(ValueError):
    """No such key, or a bad value; the text lists the keys, or what the value may be."""


@dataclass(frozen=True, slots=True)
class Key:
    """A number. ``whole``: whole numbers only. ``meaning`` includes the unit."""

    name: str
    default: float
    low: float
    high: float
    meaning: str
    whole: bool = True

    @property
    def allowed(self) -> str:
        kind = "a whole number" if self.whole else "a number"
        return f"{kind}, {self.low:.9g} to {self.high:.9g}"

    def read(self, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not self.low <= value <= self.high or (self.whole and value != int(value)):
            raise UnknownKey(f"{self.name}: {text!r} is not {self.allowed}")
        return int(value) if self.whole else value


@dataclass(frozen=True, slots=True)
class Octets:
    """Bytes in hexadecimal, as many as ``default`` has."""

    name: str
    default: str
    meaning: str

    @property
    def allowed(self) -> str:
        return f"{len(self.default) // 2} bytes in hexadecimal"

    def read(self, text: str) -> str:
        try:
            data = bytes.fromhex(text)
        except ValueError:
            data = b""
        if len(data) != len(self.default) // 2:
            raise UnknownKey(f"{self.name}: {text!r} is not {self.allowed}")
        return data.hex()


def baud(default: int) -> Key:
    """Return the key for the bit rate of a vehicle's line; every vehicle has it."""
    return Key("baud", default, 300, 4_000_000, "bit/s of its line, where the link's URL has none")


Keys = tuple[Key | Octets, ...]
Wire = Mapping[str, Any]  # by name: a number, or bytes in hexadecimal


def read_wire(keys: Keys, given: Mapping[str, str]) -> Wire:
    """Return every key with its value, given or default. Raises UnknownKey."""
    there = {key.name: key for key in keys}
    for name in given:
        if name not in there:
            raise UnknownKey(f"no key {name:.40} of wire; there are: {', '.join(there)}")
    return {n: k.read(given[n]) if n in given else k.default for n, k in there.items()}
