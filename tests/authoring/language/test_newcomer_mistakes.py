"""What somebody from another system writes first: each message names line, what, and what instead."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from mission.authoring.language import draft, elsewhere
from mission.authoring.language.words import leg_words
from mission.authoring.prepare import charted
from mission.model.codes import CODES
from mission.model.diagnostics import Diagnostic
from mission.model.shipped import load_vehicle

AUV = load_vehicle("auv")


class Mistake(NamedTuple):
    name: str
    line: int
    code: str
    what: str
    instead: str
    text: str


def yaml(legs: str, top: str = "") -> str:
    return f"mission: m\n{top}legs:\n{legs}"


# fmt: off
MISTAKES = (
    Mistake("coordinates as a list", 4, "place", "a list is no place",
            "write {latitude: 30.28, longitude: 120.15}",
            yaml("  - g: {goto: [30.28, 120.15], gear: 6, timeout: 60 s}\n",
                 "home: {latitude: 30.28, longitude: 120.15}\n")),
    Mistake("home as a list", 2, "place", "a list is no place",
            "write {latitude: 30.28, longitude: 120.15}",
            yaml("  - wait 5 s\n", "home: [30.28, 120.15]\n")),
    Mistake("coordinates in brackets", 1, "place", "'[' begins no list here",
            "write a place without brackets: 30.28 120.15",
            "g: goto [30.28, 120.15] gear 6 timeout 60\n"),
    Mistake("lat and lon", 3, "place", "this is no place",
            "write {latitude: 30.28, longitude: 120.15}",
            yaml("  - g: {goto: {lat: 30.28, lon: 120.15}, gear: 6, timeout: 60 s}\n")),
    Mistake("a colon forgotten in a line", 1, "colon", "a colon is missing behind 'dive'",
            "write dive: depth 5 for 20 s", "dive depth 5 for 20 s\n"),
    Mistake("a colon forgotten behind a leg's name", 3, "colon", "a colon is missing here",
            "write dive: {depth: 5 m, for: 20 s}", yaml("  - dive {depth: 5 m, for: 20 s}\n")),
    Mistake("a colon forgotten behind a key", 4, "colon", "a colon is missing here",
            "write depth: 5 m", yaml("  - dive:\n      depth 5 m\n      for: 20 s\n")),
    Mistake("a colon forgotten between braces", 3, "colon", "a colon is missing behind 'depth'",
            "write depth: 5 m", yaml("  - dive: {depth 5 m, for: 20 s}\n")),
    Mistake("a colon forgotten in the first line", 1, "colon", "a colon is missing here",
            "write mission: m", "mission m\nlegs:\n  - wait 5 s\n"),
    Mistake("rounds without a name", 1, "rounds", "'repeat 3' opens no group",
            "write repeat 3 name:", "repeat 3:\nwait 5\nend\n"),
    Mistake("rounds as an item", 3, "control-word", "'repeat' is no leg's name",
            "write - name: {repeat: 3, legs: [...]}", yaml("  - repeat 3:\n      - wait 5 s\n")),
    Mistake("loop", 1, "rounds", "'loop 3 r' opens no group",
            "write repeat 3 r:", "loop 3 r:\nwait 5\nend\n"),
    Mistake("then as a key", 3, "unknown-word", "a leg has no key 'then'",
            "write the way on behind its guard: until: depth > 5 -> name",
            yaml("  - dive: {depth: 5 m, until: depth > 4, then: up, timeout: 60 s}\n")),
    Mistake("then in a line", 1, "unknown-word", "unknown word 'then'",
            "write the way on behind its guard: until depth > 5 -> name",
            "dive: depth 5 until depth > 4 then up timeout 60\nup: surface timeout 60\n"),
    Mistake("if as a key", 3, "unknown-word", "a leg has no key 'if'",
            "write until: depth > 5 -> name",
            yaml("  - dive: {depth: 5 m, if: depth > 4, timeout: 60 s}\n")),
    Mistake("if as a statement", 2, "unknown-word", "unknown word 'if'",
            "write until depth > 5 -> name",
            "dive: depth 5 timeout 60\nif depth > 4 goto home\n"),
    Mistake("if as an item", 3, "control-word", "'if' is no leg's name",
            "write until: depth > 5 -> name", yaml("  - if: {depth: 5 m}\n")),
    Mistake("lawnmower", 1, "unknown-word", "unknown word 'lawnmower'",
            "write rows 4 bearing 90 length 100 spacing 20",
            "s: lawnmower 4 spacing 10 length 100 bearing 90 gear 6 timeout 60\n"),
    Mistake("lawnmower as a key", 3, "unknown-word", "a leg has no key 'lawnmower'",
            "write rows: 4, bearing: 90, length: 100, spacing: 20",
            yaml("  - s: {lawnmower: 4, gear: 6, timeout: 60 s}\n")),
    Mistake("duration", 1, "unknown-word", "unknown word 'duration'",
            "write for 60s", "s: depth 5 duration 60\n"),
    Mistake("duration as a key", 3, "unknown-word", "a leg has no key 'duration'",
            "write for: 60s", yaml("  - s: {depth: 5 m, duration: 60 s}\n")),
    Mistake("a battery in percent", 5, "unit", "battery is told in V, not as a share",
            "write the volts of your battery at that charge, for instance battery < 11",
            yaml("  - wait 5 s\n", "").rstrip() + "\non:\n  - {when: battery < 20%, do: surface}\n"),
    Mistake("a battery as a limit", 2, "unknown-word", "safety has no key 'battery'",
            "write voltage: 11", yaml("  - wait 5 s\n", "safety: {battery: 11 V}\n")),
    Mistake("a temperature that drops", 1, "unknown-word", "unknown word 'drops'",
            "write falls, for instance temperature falls 2 within 5 m",
            "s: depth 5 until temperature drops 2 C timeout 9\n"),
    Mistake("a temperature that drops, as a key", 3, "unknown-word", "unknown word 'drops'",
            "write falls, for instance temperature falls 2 within 5 m",
            yaml("  - s: {depth: 5 m, until: temperature drops 2 C, timeout: 9 s}\n")),
    Mistake("a battery that is low", 1, "comparison", "'battery' is compared with nothing",
            "write for instance battery < 11", "on battery low -> surface\nwait 5\n"),
    Mistake("heave", 1, "unknown-word", "unknown word 'heave'",
            "write up 4 or down 4", "s: heave 4 for 20\n"),
    Mistake("heave as a key", 3, "unknown-word", "a leg has no key 'heave'",
            "write up: 4 or down: 4", yaml("  - s: {heave: -4, for: 20 s}\n")),
    Mistake("yaw", 1, "unknown-word", "unknown word 'yaw'",
            "write heading 90", "s: yaw 90 gear 4 for 20\n"),
    Mistake("surge", 1, "unknown-word", "unknown word 'surge'",
            "write gear 4", "s: surge 0.5 for 20\n"),
    Mistake("waypoints", 3, "unknown-word", "a leg has no key 'waypoints'",
            "write follow: [home, north 10 east 20]",
            yaml("  - s: {waypoints: [home, home], gear: 6, timeout: 60 s}\n")),
    Mistake("a greatest depth", 1, "unknown-word", "safety has no 'max_depth'",
            "write depth 20", "safety max_depth 20\nwait 5\n"),
    Mistake("steps", 2, "unknown-word", "a mission has no key 'steps'",
            "write legs", "mission: m\nsteps:\n  - wait 5 s\n"),
    Mistake("the mission's name", 1, "unknown-word", "a mission has no key 'name'",
            "write mission", "name: m\nlegs:\n  - wait 5 s\n"),
    Mistake("metres in full", 1, "unknown-unit", "unknown unit 'meters'",
            "did you mean m?", "s: depth 5 meters for 20 s\n"),
    Mistake("feet", 1, "unknown-unit", "unknown unit 'ft'",
            "did you mean m (1 ft is 0.3048 m)?", "s: depth 15ft for 20\n"),
    Mistake("an equals sign", 1, "equality", "'=' sets nothing",
            "write depth and its value, with a blank between", "s: depth = 5 for 20\n"),
    Mistake("a comma", 1, "separator", "',' parts nothing here",
            "leave it out", "s: depth 5, gear 4 for 20\n"),
    Mistake("no clock", 1, "no-time-bound", "g is not bounded by time",
            "add timeout (or for)", "g: goto home gear 6\n"),
)
# fmt: on


def told(text: str) -> tuple[Diagnostic, ...]:
    return charted(draft(text, "m"), AUV).found


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.name)
def test_a_newcomers_mistake_is_told_with_its_line_and_what_to_write(mistake: Mistake) -> None:
    found = told(mistake.text)
    assert [d.code for d in found] == [mistake.code], [d.rendered for d in found]
    (diagnostic,) = found
    assert diagnostic.where.line == mistake.line
    assert diagnostic.text == mistake.text.split("\n")[mistake.line - 1]
    assert mistake.what in diagnostic.message
    assert diagnostic.hint.startswith(mistake.instead)
    assert diagnostic.code in CODES


def test_a_word_from_elsewhere_is_none_of_the_language() -> None:
    assert not set(elsewhere.LEG) & set(leg_words())
    assert not set(elsewhere.UNIT) & {"m", "s", "kn"}


@pytest.mark.parametrize("word", sorted(set(elsewhere.LEG) - {"then", "loop"}))
def test_what_is_written_for_a_word_from_elsewhere_can_be_read(word: str) -> None:
    """Each hint, put into a leg, has nothing unknown in it."""
    for hint in elsewhere.LEG[word].split(" or "):
        for part in hint.split(", ") if "follow" not in hint else [hint]:
            found = draft(f"name: gear 4 timeout 9\na: {part} timeout 60\n", "m").problems.found()
            assert not {d.code for d in found} & {"unknown-word", "syntax", "number", "place"}
