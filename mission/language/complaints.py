"""A line that does not fit the grammar, in words: which part, what was expected, what to write.

What does not live here: what is wrong with a line that fits (legs.py, assembly.py, values.py).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from lark import Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from mission.language.problems import nearest
from mission.language.words import ASSUMPTIONS, CLAUSES, KINDS, LIMITS, MEASURES, SETTINGS
from mission.units import UNITS
from mission.variables import VARIABLES


@dataclass(frozen=True, slots=True)
class Complaint:
    rule: str
    offset: int
    length: int
    message: str
    hint: str


# What a terminal of the grammar is called when it is missing, in the order of helpfulness.
_EXPECTED = {
    "NUMBER": "a number",
    "WORD": "a name",
    "LABEL": "a name with a colon",
    "OPERATOR": "one of < <= > >=",
    "DIGEST": "8 hex digits",
    "PORT": "port or starboard",
    "_FIX": "fix",
    "_WITHOUT": "without fix",
    "_EAST": "east and metres",
    "_NORTH": "north and east in metres",
    "_HOME": "home",
    "_HERE": "here",
    "LIMIT": "one of " + ", ".join(LIMITS),
    "ASSUMED": "one of " + ", ".join(ASSUMPTIONS),
    "SETTING": "a setting",
    "UNTIL": "a clause (until, for, timeout, else ...)",
    "RPAR": "a closing parenthesis",
}
_STATEMENTS = (
    "mission",
    "home",
    "safety",
    "assume",
    "param",
    "start",
    "repeat",
    "group",
    "end",
    "on",
)
_LEG_WORDS = (*SETTINGS, "stop", *MEASURES, *KINDS, "from", "side", *CLAUSES)
_KEYWORDS = {
    "_VEHICLE": "vehicle", "_SUM": "sum", "_HELD": "held", "_SURE": "sure", "_OR": "or",
    "_AND": "and", "_NOT": "not", "_FIX": "fix", "FIX": "fix", "_WITHOUT": "without",
    "_HOME": "home", "_HERE": "here", "_NORTH": "north", "_EAST": "east", "PORT": "port",
    "STARBOARD": "starboard", "UNCERTAIN": "uncertain", "UNTIL": "until", "FOR": "for",
    "TIMEOUT": "timeout", "ELSE": "else",
}  # fmt: skip

_PART = re.compile(r"->|[<>=!]=?|[^\s<>=!(),:]+|\S")
_NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")
_NUMBER_WORD = re.compile(r"-?(?:\d+\.?\d*|\.\d+)\Z")


def explain(text: str, error: UnexpectedInput) -> Complaint:
    """The first thing of ``text`` that does not fit, with the rule it breaks."""
    offset = _offset(text, error)
    expected = _expected(error)
    if offset >= len(text.rstrip()):
        return _unfinished(text, expected)
    offset, part = _part(text, offset)
    before = text[:offset].split()
    for known in (_by_shape, _by_context):
        found = known(text, offset, part, before[-1] if before else "", expected)
        if found is not None:
            rule, message, hint = found
            return Complaint(rule, offset, len(part), message, hint)
    return Complaint("syntax", offset, len(part), f"{part!r} does not fit here", _wanted(expected))


def _offset(text: str, error: UnexpectedInput) -> int:
    if isinstance(error, UnexpectedToken):
        token = error.token
        at_end = not isinstance(token, Token) or token.type == "$END" or token.start_pos is None
        return len(text) if at_end else int(token.start_pos or 0)
    return int(error.pos_in_stream or 0)


def _expected(error: UnexpectedInput) -> frozenset[str]:
    if isinstance(error, UnexpectedToken):
        return frozenset(error.accepts or error.expected)
    if isinstance(error, UnexpectedCharacters):
        return frozenset(error.allowed or ())
    return frozenset()


def _part(text: str, offset: int) -> tuple[int, str]:
    """The whole word that covers ``offset``, and where it begins; a unit behind its number."""
    for match in _PART.finditer(text):
        if match.start() <= offset < match.end():
            number = _NUMBER.match(match[0])
            if number and 0 < offset - match.start() == number.end():
                return offset, match[0][number.end() :]
            return match.start(), match[0]
    return offset, text[offset : offset + 1]


def _wanted(expected: frozenset[str]) -> str:
    names = [name for terminal, name in _EXPECTED.items() if terminal in expected]
    return f"expected {' or '.join(names[:4])}" if names else ""


def _unfinished(text: str, expected: frozenset[str]) -> Complaint:
    end = len(text.rstrip())
    matches = list(_PART.finditer(text))
    last = matches[-1][0] if matches else ""
    start = matches[-1].start() if matches else 0
    if text.rstrip().endswith(":"):
        hint = "write what it does, for instance  dive: depth 10 until depth >= 9.5"
        return Complaint("empty-leg", 0, end, "a name with nothing behind it", hint)
    if "RPAR" in expected and "_HELD" not in expected:
        return Complaint("parenthesis", start, end - start, "a parenthesis is not closed", "add )")
    if "OPERATOR" in expected:
        found = _no_operator("", last, expected)
        return Complaint(found[0], start, end - start, *found[1:])
    message = f"something is missing after {last!r}"
    return Complaint("unfinished", start, end - start, message, _wanted(expected))


_Found = tuple[str, str, str] | None


def _by_shape(text: str, offset: int, part: str, before: str, expected: frozenset[str]) -> _Found:
    """Things that are wrong wherever they stand."""
    if not part.isascii() or not part.isprintable():
        return "ascii", f"{part!r}: only ASCII travels to the vehicle", "comments may hold anything"
    if re.match(r"\d+:\d", text[offset:]):
        return "clock-time", "times are written with a unit", "write 90 s, 1.5 min or 2 h"
    if part in ("=", "==", "!=", "!"):
        hint = "measured values are never equal: write a range with >= and <="
        return "equality", f"{part!r} is no comparison", hint
    if part in ("&&", "||", "&", "|"):
        return "operator", f"{part!r} is no operator", "write and, or, not"
    if part in ("$", "@") or part[0] in "@$":
        return "frame", f"{part!r}: @ and $ are the wire's, not the mission's", "leave them out"
    if part in ("=>", "→") or text.startswith("=>", offset):
        return "arrow", "an arrow is written ->", "write -> and the name of a leg"
    return None


def _by_context(text: str, offset: int, part: str, before: str, expected: frozenset[str]) -> _Found:
    word = re.match(r"[A-Za-z_%/][\w/%-]*", part)
    if part in ("and", "or") and re.search(r"\bheld\b", text[:offset]):
        hint = "put held behind the last comparison, before ->"
        return "held-last", "held is for the whole guard", hint
    glued = offset > 0 and text[offset - 1].isdigit() and not text[offset - 1].isspace()
    if word and (glued or _NUMBER_WORD.fullmatch(before)):
        found = _after_number(part, glued, expected)
        if found:
            return found
    if offset == 0 or (":" in text[:offset] and not text[:offset].split(":", 1)[1].strip()):
        return _first_word(text, offset, part)
    if "OPERATOR" in expected:
        return _no_operator(part, before, expected)
    close = nearest(part, _keywords(expected))
    if close and close != part:
        return "unknown-word", f"unknown word {part!r}", f"did you mean {close}?"
    if "_NORTH" in expected:
        hint = "home, north 10 east 20, or latitude longitude"
        return "place", f"{part!r} is no place", hint
    if "NUMBER" in expected and word and before:
        return "number", f"{part!r} is no number", f"{before} needs a number"
    if re.match(r"\s*:", text[offset + len(part) :]):
        return "label", f"{part!r}: a name stands first, without blanks", "one statement a line"
    if word:
        return _unknown_word(part, expected)
    return None


def _after_number(part: str, glued: bool, expected: frozenset[str]) -> _Found:
    close_word, close_unit = nearest(part, _keywords(expected)), nearest(part, UNITS)
    if close_word and not glued and (len(part) > 3 or not close_unit):
        return "unknown-word", f"unknown word {part!r}", f"did you mean {close_word}?"
    if "UNIT" not in expected and not glued:
        return None
    hint = f"did you mean {close_unit}?" if close_unit else "units: " + ", ".join(UNITS)
    return "unknown-unit", f"unknown unit {part!r}", hint


def _first_word(text: str, offset: int, part: str) -> _Found:
    rest = text[offset + len(part) :]
    if offset == 0 and re.match(r"[^:]*:", rest) and not re.match(r"\s*\d", rest):
        label = text.split(":", 1)[0]
        if " " in label.strip() and part not in (*_STATEMENTS, *_LEG_WORDS):
            hint = f"write {'_'.join(label.split())}:"
            return "label", f"{label.strip()!r} is no name: no blanks", hint
    if offset == 0 and rest.lstrip().startswith(":"):
        hint = "a name begins with a letter and has letters, digits, _ and - only"
        return "label", f"{part!r} is no name", hint
    if part in VARIABLES and part not in _LEG_WORDS:
        return "unknown-word", f"{part!r} is a variable", f"write until {part} ..."
    close = nearest(part, (*_STATEMENTS, *_LEG_WORDS) if offset == 0 else _LEG_WORDS)
    if part == close:
        return (
            "syntax",
            f"{part!r} does not fit here",
            "a name with a colon stands before a leg only",
        )
    hint = f"did you mean {close}?" if close else "a line begins with a name, a word or ZA"
    return "unknown-word", f"unknown word {part!r}", hint


def _no_operator(part: str, before: str, expected: frozenset[str]) -> tuple[str, str, str]:
    close = nearest(before, ["fix", "uncertain", "timeout"]) if before not in VARIABLES else ""
    if not part and close:
        return "unknown-word", f"unknown word {before!r}", f"did you mean {close}?"
    if _NUMBER_WORD.fullmatch(part):
        return "comparison", "a comparison needs < <= > or >=", f"write {before} >= {part}"
    message = f"{before!r} is compared with nothing"
    return "comparison", message, f"write for instance {before} >= 1"


def _keywords(expected: frozenset[str]) -> list[str]:
    words = [_KEYWORDS[t] for t in expected if t in _KEYWORDS]
    words += _LEG_WORDS if "SETTING" in expected else []
    words += LIMITS if "LIMIT" in expected else []
    return words + (list(ASSUMPTIONS) if "ASSUMED" in expected else [])


def _unknown_word(part: str, expected: frozenset[str]) -> _Found:
    if part in (*_STATEMENTS, *_LEG_WORDS):
        return "syntax", f"{part!r} does not fit here", _wanted(expected)
    return "unknown-word", f"unknown word {part!r}", _wanted(expected)
