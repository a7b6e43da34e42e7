"""Frame tables of document 000, chapters 1.1, 1.2, 2.1: frames between topside and the Pi.

    to the Pi      @NS @NI   @AA @AC @AW @AQ @AE @AO   @ST @SP   @DU
    relayed        @RS @RI   @MT @MD @MM @MR @MS @MP   @D
    to topside     @AR

``@AW`` has a head of fixed length with binary counters (G1) and then text up to the first ``$``;
the others are pure text. @AQ, @AE, @AO and @AR use codes that the document reserves (R4).
docs/protocol.md has readings and tolerances.

What does not live here: messages (``protocol.topside``), ``@ACK_`` (``protocol.ack_frame``),
``@VS`` (``protocol.status_frame``), the report ``@AE,1`` (``protocol.state_frame``), the Z class
(``protocol.motion_frame``), ``@SD`` (``protocol.vehicles.auv``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from protocol import clocktime
from protocol.codec import CannotEncode
from protocol.fields import FaultKind, FrameType, Values, required
from protocol.text import (
    Digit,
    Int,
    Letters,
    Refused,
    Sep,
    TextFrame,
    format_decimal,
    parse_decimal,
    parse_integer,
    text_length,
)
from protocol.tolerances import Tolerances

LONG = 400  # bytes of the longest @VS and @AR
NODES = ("Pi", "STM32", "BDGPS", "UACM", "CAMERA", "AUTO")
SENSORS = ("CTD", "altimeter", "BDGPS", "UACM", "radio", "magnetometer", "light")
ALWAYS_ON = (0, 4)  # of SENSORS: the document's note to @RS
MOST_LINES = 9999  # of a mission (R3); E-F3 has the reason why it is not 65535


def letters_of(mask: int, count: int) -> str:
    """Return a mask as letters O and C; bit 0 is the first (table 3.1, and 2.1.1 by E-T3)."""
    return "".join("O" if mask >> bit & 1 else "C" for bit in range(count))


# --- 1.1 to the Pi, 1.2.1 power ---

NS: TextFrame = TextFrame("auv.NS", "000 table 1.1.1", "@NS", (Letters("switches", 6, "OC"),))
NI: TextFrame = TextFrame("auv.NI", "000 table 1.1.1", "@NI")
AA: TextFrame = TextFrame("auv.AA", "000 table 1.1.2", "@AA")
AC: TextFrame = TextFrame("auv.AC", "000 table 1.1.2", "@AC")
AQ: TextFrame = TextFrame("auv.AQ", "000 table 1.1.2, a reserved code (R4)", "@AQ")
AE: TextFrame = TextFrame("auv.AE", "000 table 1.1.2, a reserved code (R4)", "@AE")
DU: TextFrame = TextFrame("auv.DU", "000 table 1.1.4", "@DU")


def _effective(values: Values) -> None:
    switches = values["switches"]
    values["effective"] = "".join("O" if i in ALWAYS_ON else s for i, s in enumerate(switches))


RS = TextFrame(
    "auv.RS", "000 table 1.2.1", "@RS", (Letters("switches", 7, "OC"),), derive=_effective
)
RI = TextFrame("auv.RI", "000 table 1.2.1", "@RI")


class MissionLineFrame(FrameType):
    """``@AW`` total u16, current u16, payload, ``$`` (000 table 1.1.2; E-F2, E-F3, E-F7)."""

    name, title, lead = "auv.AW", "000 table 1.1.2", b"@AW"
    HEAD, MOST = 7, 200

    def __init__(self, tolerances: Tolerances) -> None:
        self._order = "little" if tolerances["order_aw"] == "low" else "big"
        self._nested, self._decimal = tolerances.on("aw_nested"), tolerances.on("aw_decimal")
        self._first = 0 if tolerances.on("aw_zero_based") else 1

    def measure(self, data: bytes, at: int, end: int) -> int | FaultKind:
        body = at + self.HEAD
        if end < body:
            return 0
        if self._counters(data[at:body]) is None:
            return FaultKind.OUT_OF_RANGE
        limit = self.HEAD + self.MOST + 1
        if self._nested and data.startswith(b"@", body):
            inner = text_length(data, at, body + 1, end, limit + 1)
            if not isinstance(inner, int) or inner == 0:
                return inner
            if at + inner == end:
                return 0
            return inner + 1 if data[at + inner] == 0x24 else FaultKind.BAD_TAIL
        return text_length(data, at, body, end, limit)

    def _counters(self, head: bytes) -> tuple[int, int] | None:
        """Return the total and the current line, counted from 1; None if they are not valid."""
        if self._decimal and head[3:7].isdigit():
            total, current = int(head[3:5]), int(head[5:7])
        else:
            order: Any = self._order
            total = int.from_bytes(head[3:5], order)
            current = int.from_bytes(head[5:7], order)
        current += 1 - self._first
        return (total, current) if 1 <= current <= total <= MOST_LINES else None

    def check(self, raw: bytes) -> FaultKind | None:
        return None if self._payload(raw) else FaultKind.EMPTY_FIELD

    def _payload(self, raw: bytes) -> str:
        nested = self._nested and raw.startswith(b"@", self.HEAD)
        return (raw[self.HEAD + 1 : -2] if nested else raw[self.HEAD : -1]).decode("ascii")

    def decode(self, raw: bytes) -> Values:
        counters = self._counters(raw[: self.HEAD])
        assert counters is not None, "check() has seen this frame"
        return {"total": counters[0], "current": counters[1], "payload": self._payload(raw)}

    def encode(self, values: Mapping[str, Any]) -> bytes:
        total, current = (required(values, key, self.name) for key in ("total", "current"))
        payload = required(values, "payload", self.name)
        if not (isinstance(total, int) and isinstance(current, int)) or not (
            1 <= current <= total <= MOST_LINES
        ):
            raise CannotEncode(f"{self.name}: lines are 1 <= current <= total <= {MOST_LINES}")
        if not isinstance(payload, str) or not re.fullmatch(r"[ -#%-?A-~]{1,200}", payload):
            raise CannotEncode(
                f"{self.name}: payload is 1 to {self.MOST} printable ASCII characters without "
                f"@ and $, not {payload!r}"
            )
        order: Any = self._order
        sent = current - 1 + self._first
        counters = total.to_bytes(2, order) + sent.to_bytes(2, order)
        inner = f"@{payload}$" if self._nested else payload
        return self.lead + counters + inner.encode("ascii") + b"$"


class TimeFrame(TextFrame):
    """``@ST,YYYY/MM/DD hh:mm:ss,$`` (000 table 1.1.3; E-V1)."""

    def __init__(self, tolerances: Tolerances) -> None:
        super().__init__("auv.ST", "000 table 1.1.3", "@ST")
        self._compact, self._commas = tolerances.on("st_compact"), tolerances.on("st_commas")

    def parse(self, body: str) -> Values:
        parts = body.split(",")
        if len(parts) == 8 and self._commas and not parts[0] and not parts[-1]:
            return {"time": clocktime.checked(tuple(parse_integer(p) for p in parts[1:-1]))}
        if len(parts) != 3 or parts[0] or parts[2]:
            raise Refused(FaultKind.FIELD_COUNT)
        text = parts[1]
        if not text:
            raise Refused(FaultKind.EMPTY_FIELD)
        if self._compact and re.fullmatch("[0-9]{14}", text):
            return {"time": clocktime.checked(clocktime.split_compact(text))}
        return {"time": clocktime.checked(clocktime.split(text, clocktime.SLASHES))}

    def format(self, values: Mapping[str, Any]) -> str:
        year, month, day, hour, minute, second = clocktime.encodable(values, self.name)
        if year not in clocktime.YEARS:
            first, last = clocktime.YEARS[0], clocktime.YEARS[-1]
            raise CannotEncode(f"{self.name}: the year of time is {first} to {last}, not {year}")
        return f",{year:04}/{month:02}/{day:02} {hour:02}:{minute:02}:{second:02},"


MOST = 65535  # greatest value of a limit in @SP


class SafetyFrame(TextFrame):
    """``@SP,radius,minutes,depth,voltage,$`` (000 table 1.1.3; E-V2): an empty or invalid item
    keeps its previous value, so it is None here and named in ``flags``."""

    ITEMS = ("radius_m", "minutes", "depth_m", "low_voltage_v")

    def __init__(self) -> None:
        super().__init__("auv.SP", "000 table 1.1.3", "@SP")

    def parse(self, body: str) -> Values:
        parts = body.split(",")
        if len(parts) != 6 or parts[0] or parts[-1]:
            raise Refused(FaultKind.FIELD_COUNT)
        values: Values = {}
        flags: list[str] = []
        for name, text in zip(self.ITEMS, parts[1:-1], strict=True):
            values[name] = self._item(name, text, flags)
        values["flags"] = flags
        return values

    @staticmethod
    def _item(name: str, text: str, flags: list[str]) -> float | None:
        try:
            value = parse_decimal(text)
        except Refused as refusal:
            reason = "empty" if refusal.kind is FaultKind.EMPTY_FIELD else refusal.kind
            flags.append(f"{name}:{reason}")
            return None
        if not 0 < value <= MOST:
            flags.append(f"{name}:{FaultKind.OUT_OF_RANGE}")
            return None
        return value

    def format(self, values: Mapping[str, Any]) -> str:
        return "," + "".join(self._text(name, values.get(name)) + "," for name in self.ITEMS)

    @staticmethod
    def _text(name: str, value: Any) -> str:
        if value is None:
            return ""
        if isinstance(value, int | float) and not 0 < value <= MOST:
            raise CannotEncode(f"{name}: {value} is outside 0..{MOST} (0 excluded)")
        return format_decimal(name, value)


class OutputFrame(TextFrame):
    """``@AO,name,value,$`` (R4): sets an output, by its name in the vehicle file."""

    NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,23}")

    def __init__(self) -> None:
        super().__init__("auv.AO", "000 table 1.1.2, a reserved code (R4)", "@AO")

    def parse(self, body: str) -> Values:
        parts = body.split(",")
        if len(parts) != 4 or parts[0] or parts[-1]:
            raise Refused(FaultKind.FIELD_COUNT)
        if not parts[1]:
            raise Refused(FaultKind.EMPTY_FIELD)
        if not self.NAME.fullmatch(parts[1]):
            raise Refused(FaultKind.BAD_ENUM)
        return {"name": parts[1], "value": parse_decimal(parts[2])}

    def format(self, values: Mapping[str, Any]) -> str:
        name, value = (required(values, key, self.name) for key in ("name", "value"))
        if not self.NAME.fullmatch(str(name)):
            raise CannotEncode(f"name: {name!r} is not a letter and at most 23 letters, digits, _")
        return f",{name},{format_decimal('value', value)},"


# --- 1.2.2 remote control ---

RUDDER_TRAVEL = (-15, 22)  # deg, up positive
SERVO = (Letters("mode", 1, "AS"), Digit("servo", "123"), Sep(","), Int("angle", -37, 37))


def _rudder(values: Values) -> FaultKind | None:
    """Check the angle: with S it must be within the travel; with A any step up to the whole travel
    is allowed."""
    lowest, highest = RUDDER_TRAVEL
    beyond = values["mode"] == "S" and not lowest <= values["angle"] <= highest
    return FaultKind.OUT_OF_RANGE if beyond else None


MT = TextFrame(
    "auv.MT", "000 table 1.2.2", "@MT", (Int("thruster", 1, 5), Sep(","), Int("gear", -12, 12))
)
MD = TextFrame("auv.MD", "000 table 1.2.2", "@MD", SERVO, rule=_rudder)
D = TextFrame("auv.D", "000 table 1.2.2", "@D", SERVO, rule=_rudder)
MM = TextFrame("auv.MM", "000 table 1.2.2", "@MM", (Letters("dir", 1, "FBUD"), Int("speed", 0, 12)))
MR = TextFrame(
    "auv.MR", "000 table 1.2.2", "@MR", (Letters("dir", 1, "LRBFUD"), Int("speed", 0, 5))
)


def stick(kind: str, first: str, tolerances: Tolerances) -> TextFrame:
    """``@MS`` and ``@MP``: speed or force, then the direction: 0 starboard, counter-clockwise
    (E-V12)."""
    least = 0 if tolerances.on("ms_zero") else 1
    items = (Int(first, least, 120), Sep(","), Int("angle", -180, 180))
    return TextFrame(f"auv.{kind}", "000 table 1.2.2", f"@{kind}", items)


# --- 2.1 to topside ---


class StoreFrame(TextFrame):
    """``@AR,state,total,have,missing,digest,refusal,$`` (R4)."""

    STATES = ("empty", "staging", "ready", "running")
    _MISSING = re.compile(r"([0-9]{1,4}(-[0-9]{1,4})?(\.[0-9]{1,4}(-[0-9]{1,4})?)*)?")
    _DIGEST = re.compile(r"([0-9a-f]{16})?")

    def __init__(self) -> None:
        super().__init__("auv.AR", "000 table 1.1.2, a reserved code (R4)", "@AR", limit=LONG)

    def parse(self, body: str) -> Values:
        parts = body.split(",")
        if len(parts) != 8 or parts[0] or parts[-1]:
            raise Refused(FaultKind.FIELD_COUNT)
        _, state, total, have, missing, digest, refusal, _ = parts
        if state not in self.STATES:
            raise Refused(FaultKind.BAD_ENUM)
        counts = {"total": parse_integer(total), "have": parse_integer(have)}
        if not 0 <= counts["have"] <= counts["total"] <= MOST_LINES:
            raise Refused(FaultKind.OUT_OF_RANGE)
        if not (self._MISSING.fullmatch(missing) and self._DIGEST.fullmatch(digest)):
            raise Refused(FaultKind.NON_NUMERIC)
        if len(refusal) > 200:
            raise Refused(FaultKind.BAD_LENGTH)
        texts = {"missing": missing, "digest": digest, "refusal": refusal}
        return {"state": state, **counts, **texts}

    def format(self, values: Mapping[str, Any]) -> str:
        names = ("state", "total", "have", "missing", "digest", "refusal")
        texts = [str(required(values, name, self.name)) for name in names]
        wrong = next((t for t in texts if not re.fullmatch(r"[ -#%-+\--?A-~]*", t)), None)
        if wrong is not None:
            raise CannotEncode(f"{self.name}: {wrong!r} is not printable ASCII without , @ and $")
        return "," + ",".join(texts) + ","
