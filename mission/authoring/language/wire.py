"""Errors in a ZA command, and what to write instead (document 000, table 2.2.2).

What does not live here: what a valid command sets (settings.py), which codes exist (words.py).
"""

from __future__ import annotations

import math
import re

from mission.authoring.language.words import ATTITUDE, REFUSED_ZA, SETTINGS, ZA
from mission.model.units import GEARS

_LONGEST = 40  # characters: longer than any sensible command
_FORM = re.compile(r"ZA([A-Z])(-?\d+)\Z")


def wire_complaint(word: str) -> tuple[str, str, str] | None:
    """What is wrong with a ZA command (rule, message, hint), or None."""
    bare = word.strip("@$")
    if bare != word:
        return "frame", f"{word}: the frame's @ and $ stay outside", f"write {bare}"
    if len(bare) > _LONGEST:
        return "wire-form", f"{word[:_LONGEST]}...: no ZA word is as long as that", "write ZAF6"
    code = bare[2]
    if bare[:3] != bare[:3].upper():
        return "wire-case", f"{word}: ZA words are upper case", f"write {bare.upper()}"
    if code in REFUSED_ZA:
        return "wire-refused", f"{word} is no word of a mission", REFUSED_ZA[code]
    if code == ATTITUDE:
        return _attitude_complaint(word)
    if code not in ZA:
        codes = " ".join([*ZA, ATTITUDE])
        return "wire-code", f"{word}: there is no ZA{code}", f"codes: {codes}"
    match = _FORM.match(bare)
    row = ZA[code]
    if match is None:
        return _number_complaint(word, bare, row.word)
    if not row.low <= int(match[2]) <= row.high:
        return _range_complaint(word, code, match[2])
    return None


def _attitude_complaint(word: str) -> tuple[str, str, str] | None:
    match = re.fullmatch(r"ZAA(-?\d+)([;,])(-?\d+)", word)
    if match is None:
        return "wire-form", f"{word}: pitch and roll are needed", "write for instance ZAA5;-3"
    if match[2] == ",":
        return (
            "wire-form",
            f"{word}: a semicolon parts pitch and roll",
            f"write ZAA{match[1]};{match[3]}",
        )
    if any(abs(int(v)) > 90 for v in (match[1], match[3])):
        return "range", f"{word} is out of range", "pitch and roll go from -90 to 90"
    return None


def _number_complaint(word: str, bare: str, setting: str) -> tuple[str, str, str]:
    number = re.fullmatch(r"ZA[A-Z]\+?(-?\d+(?:\.\d+)?)", bare)
    if number is None:
        return "wire-form", f"{word}: a whole number is needed", f"write for instance {bare[:3]}6"
    if SETTINGS[setting].gear or "+" in bare:
        whole = round(float(number[1]))
        return "wire-form", f"{word}: the wire has whole numbers", f"write {bare[:3]}{whole}"
    below = math.floor(float(number[1]))
    hint = f"write {bare[:3]}{below} or {bare[:3]}{below + 1}"
    return "wire-form", f"{word}: the wire has whole numbers", hint


def _range_complaint(word: str, code: str, digits: str) -> tuple[str, str, str]:
    row = ZA[code]
    splits = [
        f"ZA{code}{digits[:n]} for {int(digits[n:])}s"
        for n in (1, 2)
        if len(digits) > n and digits.isdigit() and int(digits[:n]) <= GEARS and int(digits[n:])
    ]
    if SETTINGS[row.word].gear and len(digits) >= 3 and splits:
        message = f"{word}: gear and seconds run together"
        return "run-together", message, f"write {' or '.join(splits)}"
    hint = f"{row.description}: {row.low} to {row.high}"
    return "range", f"{word} is out of range", hint
