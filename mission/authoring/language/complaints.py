"""Explain why a line does not fit the grammar: which part, what was expected, what to write.

What does not live here: errors in a line that fits the grammar (legs.py, assembly.py, values.py).
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from lark import Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from mission.authoring.language import elsewhere
from mission.authoring.language.words import (
    AIMS,
    ASSUMPTIONS,
    LIMITS,
    SETTINGS,
    choices,
    leg_words,
)
from mission.engine.variables import VARIABLES
from mission.model.likeness import nearest
from mission.model.units import UNITS


@dataclass(frozen=True, slots=True)
class Complaint:
    code: str
    offset: int
    length: int
    message: str
    hint: str


# How messages name a missing terminal of the grammar; the most helpful names first.
_EXPECTED = {
    "NUMBER": "a number",
    "WORD": "a name",
    "LABEL": "a name with a colon",
    "OPERATOR": "one of < <= > >=",
    "MOVES": "falls or rises",
    "EXTREME": "highest or lowest",
    "DIGEST": "8 hex digits",
    "_FIX": "fix",
    "_WITHOUT": "without fix",
    "_EAST": "east and metres",
    "_NORTH": "north and east in metres",
    "AT_HOME": "home",
    "HERE": "here",
    "_ARROW": "-> and a target",
    "LIMIT": "one of " + ", ".join(LIMITS),
    "ASSUMED": "one of " + ", ".join(ASSUMPTIONS),
    "AIM": "one of " + ", ".join(AIMS),
    "SETTING": "a setting",
    "UNTIL": "a clause (until, for, timeout, else ...)",
    "RPAR": "a closing parenthesis",
}
_STATEMENTS = (
    "mission",
    "home",
    "safety",
    "assume",
    "keep",
    "param",
    "start",
    "repeat",
    "group",
    "end",
    "on",
)
_TARGETS = "write -> and the name of a leg"
_KEYWORDS = {
    "_VEHICLE": "vehicle", "_SUM": "sum", "_HELD": "held", "_SURE": "sure", "_OR": "or",
    "_NEVER": "never", "_BELOW": "below", "_KEEP": "keep", "KEEP_IN": "in", "KEEP_OUT": "out",
    "_BETWEEN": "between",
    "_AND": "and", "_NOT": "not", "_FIX": "fix", "FIX": "fix", "_WITHOUT": "without",
    "AT_HOME": "home", "HERE": "here", "_NORTH": "north", "_EAST": "east",
    "UNCERTAIN": "uncertain", "UNTIL": "until", "FOR": "for", "TIMEOUT": "timeout", "ELSE": "else",
    "OUTPUT": "output", "_ACHIEVE": "achieve",
    "_BACK": "back", "_AT": "at", "WITHIN": "within",
}  # fmt: skip

_PART = re.compile(r"->|[<>=!]=?|[^\s<>=!(),:]+|\S")
_NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)")
_NUMBER_WORD = re.compile(r"-?(?:\d+\.?\d*|\.\d+)\Z")


@dataclass(frozen=True, slots=True)
class _Misfit:
    """The word of ``text`` that does not fit, the word before it, and the terminals that fit."""

    text: str
    offset: int
    part: str
    before: str
    expected: frozenset[str]

    def says(self, code: str, message: str, hint: str) -> Complaint:
        return Complaint(code, self.offset, len(self.part), message, hint)

    @property
    def word(self) -> bool:
        return re.match(r"[A-Za-z_%/]", self.part) is not None

    @property
    def glued(self) -> bool:
        return self.offset > 0 and self.text[self.offset - 1].isdigit()

    @property
    def first(self) -> bool:
        """Whether the word begins the line, or directly follows the name."""
        return not self.text[: self.offset].split(":", 1)[-1].strip()

    def keywords(self) -> list[str]:
        """Every word that would fit."""
        words = [_KEYWORDS[t] for t in self.expected if t in _KEYWORDS]
        words += leg_words() if "SETTING" in self.expected else []
        words += _chosen() if "CHOSEN" in self.expected else []
        words += LIMITS if "LIMIT" in self.expected else []
        words += AIMS if "AIM" in self.expected else []
        return words + (list(ASSUMPTIONS) if "ASSUMED" in self.expected else [])


def explain(text: str, error: UnexpectedInput) -> Complaint:
    """Explain the first part of ``text`` that does not fit, by the first rule that applies."""
    offset, expected = _offset(text, error), _expected(error)
    if offset >= len(text.rstrip()):
        return _unfinished(text, expected)
    offset, part = _part(text, offset)
    before = [match[0] for match in _PART.finditer(text[:offset])]
    misfit = _Misfit(text, offset, part, before[-1] if before else "", expected)
    for rule in (_by_shape, _by_number, _by_place, _by_word):
        found = rule(misfit)
        if found is not None:
            return found
    return misfit.says("syntax", f"{part!r} does not fit here", _wanted(expected))


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
    """Where the word that covers ``offset`` begins, and the word; or the unit behind a number."""
    for match in _PART.finditer(text):
        if match.start() <= offset < match.end():
            number = _NUMBER.match(match[0])
            if number and 0 < offset - match.start() == number.end():
                return offset, match[0][number.end() :]
            return match.start(), match[0]
    return offset, text[offset : offset + 1]


def _chosen() -> list[str]:
    return [value for row in choices().values() for value in row.values]


def _wanted(expected: frozenset[str]) -> str:
    names = [name for terminal, name in _EXPECTED.items() if terminal in expected]
    names += [" or ".join(_chosen())] if "CHOSEN" in expected else []
    names += sorted(word for terminal, word in _KEYWORDS.items() if terminal in expected)
    return f"expected {' or '.join(names[:4])}" if names else "one statement a line"


def _unfinished(text: str, expected: frozenset[str]) -> Complaint:
    end = len(text.rstrip())
    matches = list(_PART.finditer(text))
    last, start = (matches[-1][0], matches[-1].start()) if matches else ("", 0)
    misfit = _Misfit(text, start, last, last, expected)
    if text.rstrip().endswith(":"):
        hint = "write what it does, for instance  dive: depth 10 until depth >= 9.5"
        return Complaint("empty-leg", 0, end, "a name with nothing behind it", hint)
    if "RPAR" in expected and "_HELD" not in expected:
        return misfit.says("parenthesis", "a parenthesis is not closed", "add )")
    if "OPERATOR" in expected:
        return _no_operator(misfit, "")
    return misfit.says("unfinished", f"something is missing after {last!r}", _wanted(expected))


# --- the rules, in the order in which they are tried ----------------------------------------------


def _by_shape(misfit: _Misfit) -> Complaint | None:
    """Mistakes that are wrong at any place in a line."""
    part, at = misfit.part, misfit.text[misfit.offset :]
    if not part.isascii() or not part.isprintable():
        hint = "comments may hold anything"
        return misfit.says("ascii", f"{part!r}: only ASCII travels to the vehicle", hint)
    if re.match(r"\d+:\d", at):
        hint = "write 90 s, 1.5 min or 2 h"
        return misfit.says("clock-time", "times are written with a unit", hint)
    if at.startswith("=>") and "OPERATOR" in misfit.expected:
        return Complaint("comparison", misfit.offset, 2, "at least is written >=", "write >=")
    if at.startswith("=>"):
        return Complaint("arrow", misfit.offset, 2, "an arrow is written ->", _TARGETS)
    if part == "=" and misfit.before in SETTINGS and "OPERATOR" not in misfit.expected:
        hint = f"write {misfit.before} and its value, with a blank between"
        return misfit.says("equality", "'=' sets nothing", hint)
    if part in ("=", "==", "!=", "!"):
        hint = "measured values are never equal: write a range with >= and <="
        return misfit.says("equality", f"{part!r} is no comparison", hint)
    if part in ("&&", "||", "&", "|"):
        return misfit.says("operator", f"{part!r} is no operator", "write and, or, not")
    if part in ",;":
        hint = "leave it out: blanks part the words, and each statement has its line"
        return misfit.says("separator", f"{part!r} parts nothing here", hint)
    if part[0] in "[({" and ("_NORTH" in misfit.expected or part[0] != "("):
        hint = "write a place without brackets: 30.28 120.15, north 10 east 20, or home"
        return misfit.says("place", f"{part[0]!r} begins no list here", hint)
    if part[0] in "@$":
        message = f"{part!r}: @ and $ are the wire's, not the mission's"
        return misfit.says("frame", message, "leave them out")
    return None


def _by_number(misfit: _Misfit) -> Complaint | None:
    """A word directly behind a number is a wrong unit, unless it resembles a word that fits."""
    part, expected = misfit.part, misfit.expected
    behind = misfit.glued or _NUMBER_WORD.fullmatch(misfit.before)
    labelled = re.match(r"\s*:", misfit.text[misfit.offset + len(part) :])
    if not misfit.word or not behind or labelled or _is_word(part):
        return None
    if part in elsewhere.LEG and not misfit.glued:
        return _brought(misfit)
    # where a unit may stand, a long word counts as a unit unless it closely resembles a word
    likeness = 0.75 if "UNIT" in expected and len(part) > 5 else 0.6
    close_word, close_unit = nearest(part, misfit.keywords(), likeness), nearest(part, UNITS)
    if close_word and not misfit.glued and (len(part) > 3 or not close_unit):
        return misfit.says("unknown-word", f"unknown word {part!r}", f"did you mean {close_word}?")
    if "UNIT" not in expected and not misfit.glued:
        return None
    close_unit = elsewhere.UNIT.get(part.lower(), close_unit)
    hint = f"did you mean {close_unit}?" if close_unit else "units: " + ", ".join(UNITS)
    return misfit.says("unknown-unit", f"unknown unit {part!r}", hint)


def _by_place(misfit: _Misfit) -> Complaint | None:
    """Mistakes that follow from the place in the line."""
    text, offset, part, expected = misfit.text, misfit.offset, misfit.part, misfit.expected
    if part in ("and", "or") and re.search(r"\bheld\b", text[:offset]):
        hint = "put held behind the last comparison, before ->"
        return misfit.says("held-last", "held is for the whole guard", hint)
    if re.match(r"(?:repeat|loop)\s+\d+\s*:", text):
        return _rounds(misfit, text.partition(":")[0].split())
    if misfit.first and "_NORTH" not in expected:  # else it is a place, alone in a YAML value
        return _first_word(misfit)
    if re.match(r"\s*:", text[offset + len(part) :]):
        message = f"{part!r}: a name stands first, without blanks"
        return misfit.says("label", message, "one statement a line")
    if "OPERATOR" in expected:
        return _no_operator(misfit, part)
    if "RPAR" in expected and "LPAR" not in expected:
        return misfit.says("parenthesis", "a parenthesis is not closed", f"add ) before {part}")
    return None


def _by_word(misfit: _Misfit) -> Complaint | None:
    """Suggest a word for one that is misspelt or unknown."""
    part, expected, wanted = misfit.part, misfit.expected, _wanted(misfit.expected)
    if part == ":" and misfit.text.startswith("repeat"):
        hint = f"write repeat 2 {misfit.before}:"
        return misfit.says("count", "repeat needs a count", hint)
    if "WORD" in expected and not {"NUMBER", "LPAR"} & expected:
        hint = "a letter, then letters, digits, _ and -"
        return misfit.says("label", f"{part!r} is no name", hint)
    if not misfit.word:
        return None
    if "LIMIT" in expected and part in elsewhere.SAFETY:
        hint = f"write {elsewhere.SAFETY[part]}"
        return misfit.says("unknown-word", f"safety has no {part!r}", hint)
    if part in elsewhere.LEG and "_NORTH" not in expected:
        return _brought(misfit)
    close = nearest(part, misfit.keywords())
    if close and close != part:
        return misfit.says("unknown-word", f"unknown word {part!r}", f"did you mean {close}?")
    if "_NORTH" in expected:
        hint = "home, north 10 east 20, or latitude longitude"
        return misfit.says("place", f"{part!r} is no place", hint)
    if "NUMBER" in expected and misfit.before:
        message, hint = f"{part!r} is no number", f"{misfit.before} needs a number"
        return misfit.says("number", message, hint)
    if _is_word(part):
        return misfit.says("syntax", f"{part!r} does not fit here", wanted)
    return misfit.says("unknown-word", f"unknown word {part!r}", wanted)


def _brought(misfit: _Misfit) -> Complaint:
    hint = f"write {elsewhere.LEG[misfit.part]}"
    return misfit.says("unknown-word", f"unknown word {misfit.part!r}", hint)


def _is_word(part: str) -> bool:
    return part in _STATEMENTS or part in leg_words()


def _first_word(misfit: _Misfit) -> Complaint:
    part, at_start = misfit.part, misfit.offset == 0
    label = misfit.text.split(":", 1)[0].strip() if ":" in misfit.text else ""
    if at_start and part in ("repeat", "loop") and label:
        return _rounds(misfit, label.split())
    behind = misfit.text[len(part) :].split()
    if at_start and not label and part not in elsewhere.CONTROL and behind and _of_leg(behind[0]):
        hint = f"write {part}: {misfit.text[len(part) :].strip():.40}"
        return misfit.says("colon", f"a colon is missing behind {part!r}", hint)
    if at_start and " " in label and not _is_word(part):
        hint = f"write {'_'.join(label.split())}:"
        return Complaint("label", 0, len(label), f"{label!r} is no name: no blanks", hint)
    if at_start and label == part:
        hint = "a name begins with a letter and has letters, digits, _ and - only"
        return misfit.says("label", f"{part!r} is no name", hint)
    if part in VARIABLES and not _is_word(part):
        return misfit.says("unknown-word", f"{part!r} is a variable", f"write until {part} ...")
    if _is_word(part):
        hint = "a name with a colon stands before a leg only"
        return misfit.says("syntax", f"{part!r} does not fit here", hint)
    if part in elsewhere.LEG:
        return _brought(misfit)
    close = nearest(part, (*_STATEMENTS, *leg_words()) if at_start else leg_words())
    hint = f"did you mean {close}?" if close else "a line begins with a name, a word or ZA"
    return misfit.says("unknown-word", f"unknown word {part!r}", hint)


def _of_leg(word: str) -> bool:
    return word in leg_words() or re.match(r"ZA[A-Z]", word) is not None


def _rounds(misfit: _Misfit, words: list[str]) -> Complaint:
    """Explain a wrong group head, as ``repeat 3:`` or ``loop 3 r:``."""
    count = next((word for word in words[1:] if word.isdigit()), "3")
    name = next((word for word in words[1:] if not word.isdigit()), "name")
    said, length = " ".join(words), misfit.text.index(":") + 1
    message = f"{said!r} opens no group: it needs the word repeat, a count and a name"
    return Complaint("rounds", 0, length, message, f"write repeat {count} {name}:")


def _no_operator(misfit: _Misfit, part: str) -> Complaint:
    """``part`` follows a variable instead of a comparison."""
    before = misfit.before
    start = misfit.text.rindex(before, 0, misfit.offset + len(before))
    close = nearest(before, ["fix", "uncertain", "timeout"]) if before not in VARIABLES else ""
    if close and part in ("", "->"):
        message = f"unknown word {before!r}"
        return Complaint("unknown-word", start, len(before), message, f"did you mean {close}?")
    if _NUMBER_WORD.fullmatch(part):
        hint = f"write {before} >= {part}"
        return misfit.says("comparison", "a comparison needs < <= > or >=", hint)
    if before in VARIABLES and part in elsewhere.TREND:
        word = elsewhere.TREND[part]
        hint = f"write {word}, for instance {before} {word} 2 within 5 m"
        return misfit.says("unknown-word", f"unknown word {part!r}", hint)
    example = "battery < 11" if before == "battery" else f"{before} >= 1"
    message, hint = f"{before!r} is compared with nothing", f"write for instance {example}"
    return Complaint("comparison", start, len(before), message, hint)
