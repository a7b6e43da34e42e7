"""Text frames of document 000: ``@`` letters, parameters, ``$``; one table encodes and decodes.

    MT = TextFrame("auv.MT", "000 table 1.2.2", "@MT",
                   (Int("thruster", 1, 5), Sep(","), Int("gear", -12, 12)))

Strict grammar (E-F6): integers are ``-?[0-9]{1,5}``, no blanks, no ``+``; printable ASCII only. An
``@`` inside or a length beyond ``limit`` ends the candidate. A frame with a value out of range is
refused.

What does not live here: binary frames (``protocol.fields``) and the tables themselves
(``protocol.topside_frames``, ``protocol.vehicles.auv``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values, required

LIMIT = 64
_INTEGER = re.compile(r"-?[0-9]{1,5}")
_DECIMAL = re.compile(r"-?[0-9]{1,9}(\.[0-9]+)?")  # decimals as programs print them
_END_OR_BAD = re.compile(rb"[^\x20-\x23\x25-\x3f\x41-\x7e]")  # "$", "@" or not printable
_TAIL, _TAIL_BYTE = b"$", 0x24


class Refused(Exception):
    """Raised in parsers only; ``check`` returns its FaultKind."""

    def __init__(self, kind: FaultKind) -> None:
        super().__init__(kind)
        self.kind = kind


def text_length(data: bytes, at: int, body: int, end: int, limit: int) -> int | FaultKind:
    """Return the length of a text candidate, up to its first ``$``; 0 if that is still to come.
    ``body``: where the text begins, behind the lead."""
    found = _END_OR_BAD.search(data, body, min(end, at + limit))
    if found is None:
        return FaultKind.BAD_LENGTH if end - at >= limit else 0
    if data[found.start()] != _TAIL_BYTE:
        return FaultKind.BAD_CHAR
    return found.end() - at


def parse_integer(text: str) -> int:
    if not text:
        raise Refused(FaultKind.EMPTY_FIELD)
    if _INTEGER.fullmatch(text):
        return int(text)
    long_number = text.isascii() and text.removeprefix("-").isdigit()
    raise Refused(FaultKind.OUT_OF_RANGE if long_number else FaultKind.NON_NUMERIC)


def parse_decimal(text: str) -> float:
    """Return an int if ``text`` has no point, so that it is encoded without one again."""
    if not text:
        raise Refused(FaultKind.EMPTY_FIELD)
    if not _DECIMAL.fullmatch(text):
        raise Refused(FaultKind.NON_NUMERIC)
    return float(text) if "." in text else int(text)


def format_decimal(name: str, value: Any, places: int | None = None) -> str:
    """Write a number as short as possible without exponent, or with ``places`` decimals."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise CannotEncode(f"{name}: a number is needed, not {value!r}")
    if not abs(value) < 1e9:
        raise CannotEncode(f"{name}: {value} is outside -999999999..999999999")
    text = f"{value:.{12 if places is None else places}f}"
    if places is None:
        text = str(value) if isinstance(value, int) else _shortest(value)
    return "0" if text == "-0" else text


def _shortest(value: float) -> str:
    text = repr(value)
    if "e" in text or len(text.partition(".")[2]) > 12:
        text = f"{value:.12f}"
    return text.rstrip("0").rstrip(".")


# --- the items of a table ---


@dataclass(frozen=True, slots=True)
class Sep:
    """A literal character between two parameters."""

    char: str


@dataclass(frozen=True, slots=True)
class Letters:
    """Exactly ``size`` letters, each one of ``choices``."""

    name: str
    size: int
    choices: str

    def parse(self, text: str) -> Any:
        if not text:
            raise Refused(FaultKind.EMPTY_FIELD)
        if len(text) != self.size:
            raise Refused(FaultKind.BAD_LENGTH)
        if any(letter not in self.choices for letter in text):
            raise Refused(FaultKind.BAD_ENUM)
        return text

    def format(self, value: Any) -> str:
        if not isinstance(value, str) or len(value) != self.size:
            raise CannotEncode(f"{self.name}: {self.size} letters are needed, not {value!r}")
        wrong = [letter for letter in value if letter not in self.choices]
        if wrong:
            raise CannotEncode(f"{self.name}: {wrong[0]!r} is none of {self.choices}")
        return value


@dataclass(frozen=True, slots=True)
class Digit:
    """One digit, read as a number; ``choices`` are the digits allowed."""

    name: str
    choices: str
    size: int = 1

    def parse(self, text: str) -> Any:
        return int(Letters(self.name, 1, self.choices).parse(text))

    def format(self, value: Any) -> str:
        return Letters(self.name, 1, self.choices).format(str(value))


@dataclass(frozen=True, slots=True)
class Int:
    """An integer up to the next separator."""

    name: str
    low: int
    high: int
    size: int = 0

    def parse(self, text: str) -> Any:
        value = parse_integer(text)
        if not self.low <= value <= self.high:
            raise Refused(FaultKind.OUT_OF_RANGE)
        return value

    def format(self, value: Any) -> str:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value // 1:
            raise CannotEncode(f"{self.name}: an integer is needed, not {value!r}")
        if not self.low <= value <= self.high:
            raise CannotEncode(f"{self.name}: {value} is outside {self.low}..{self.high}")
        return str(int(value))


Parameter = Letters | Digit | Int
Item = Sep | Parameter
Rule = Callable[[Values], FaultKind | None]


class TextFrame(FrameType):
    """``lead``, the items, ``$``. ``rule`` checks parameters against each other; ``derive`` adds
    values that follow from the parameters and are not in the frame."""

    def __init__(
        self,
        name: str,
        title: str,
        lead: str,
        items: Sequence[Item] = (),
        *,
        limit: int = LIMIT,
        rule: Rule | None = None,
        derive: Callable[[Values], None] | None = None,
    ) -> None:
        self.name, self.title, self.lead = name, title, lead.encode("ascii")
        self.items, self.limit, self.rule, self.derive = tuple(items), limit, rule, derive

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        return text_length(data, at, at + len(self.lead), end, self.limit)

    def check(self, raw: bytes) -> FaultKind | None:
        try:
            self.parse(self.body(raw))
        except Refused as refusal:
            return refusal.kind
        return None

    def decode(self, raw: bytes) -> Values:
        values = self.parse(self.body(raw))
        if self.derive is not None:
            self.derive(values)
        return values

    def encode(self, values: Mapping[str, Any]) -> bytes:
        raw = self.lead + self.format(values).encode("ascii") + _TAIL
        refusal = self.check(raw)
        if refusal is not None:
            raise CannotEncode(f"{self.name}: {dict(values)} is {refusal}")
        return raw

    def body(self, raw: bytes) -> str:
        return raw[len(self.lead) : -1].decode("latin-1")

    def parse(self, body: str) -> Values:
        """Raises Refused."""
        values = parse_items(self.items, body)
        refusal = self.rule(values) if self.rule is not None else None
        if refusal is not None:
            raise Refused(refusal)
        return values

    def format(self, values: Mapping[str, Any]) -> str:
        """Raises CannotEncode."""
        return format_items(self.items, values, self.name)


def parse_items(items: Sequence[Item], body: str) -> Values:
    """Check the number of separators (``field_count``), then read the parameters from left to
    right. Raises Refused."""
    separators = {item.char for item in items if isinstance(item, Sep)}
    if any(isinstance(item, Int) for item in items):
        separators.add(",")
    for char in separators:
        if body.count(char) != sum(isinstance(i, Sep) and i.char == char for i in items):
            raise Refused(FaultKind.FIELD_COUNT)
    values: Values = {}
    at = 0
    for i, item in enumerate(items):
        if isinstance(item, Sep):
            at += 1
            continue
        stop = at + item.size if _bounded(items, i) else _next_separator(items[i + 1 :], body, at)
        values[item.name] = item.parse(body[at:stop])
        at = stop
    if body[at:]:
        raise Refused(FaultKind.BAD_LENGTH)
    return values


def _bounded(items: Sequence[Item], i: int) -> bool:
    """Whether another parameter follows directly: then the size of this one gives its end."""
    follower = items[i + 1] if i + 1 < len(items) else None
    return follower is not None and not isinstance(follower, Sep)


def _next_separator(rest: Sequence[Item], body: str, at: int) -> int:
    if rest and isinstance(rest[0], Sep):
        found = body.find(rest[0].char, at)
        return len(body) if found < 0 else found
    return len(body)


def format_items(items: Sequence[Item], values: Mapping[str, Any], frame: str) -> str:
    return "".join(
        item.char if isinstance(item, Sep) else item.format(required(values, item.name, frame))
        for item in items
    )
