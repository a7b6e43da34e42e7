"""Missions of the campaign's own: short, and each with the one leg that a scene needs.

What does not live here: the scenes (scenes), missions that are shipped (missions/).
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

from mission.authoring.language import parse
from mission.model import Mission

_HOME = "home 30.2874595 120.1535765\n"
_PASS = "up: surface until fix timeout 3min\n"

TEXTS: Mapping[str, str] = {
    # There and back at 6 m, three minutes.
    "there": "mission there vehicle auv\n" + _HOME
    + "safety radius 600 time 20min depth 10 voltage 10\nassume current 0.5 start 100\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "out: heading 0 gear 8 for 60\nback: heading 180 gear 8 for 60\n" + _PASS,
    # A long way one way, which ends by its clock.
    "away": "mission away vehicle auv\n" + _HOME
    + "safety radius 1500 time 30min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: heading 0 gear 8 for 6min\n" + _PASS,
    # Deep, and long at one depth.
    "deep": "mission deep vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 14 heading 0 gear 4 until depth >= 13.5 timeout 4min\n"
    "stand: depth 14 heading 0 gear 4 for 4min\n" + _PASS,
    # Above a floor at 30 m.
    "bottom": "mission bottom vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 29 voltage 10\nassume current 0.5 floor 30\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "follow: altitude 20 heading 0 gear 4 for 3min else up\n" + _PASS,
    # At a depth that is kept above that floor.
    "clear": "mission clear vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 29 voltage 10\nassume current 0.5 floor 16\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "along: depth 24 never below altitude 8 heading 0 gear 4 for 3min\n" + _PASS,
    # Along a shoal, at the surface.
    "shoal": "mission shoal vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.05\n"
    "keep out shoal: north 150 east -300, north 150 east 500, north 500 east 500, "
    "north 500 east -300\n"
    "go: heading 90 gear 4 for 5min\n" + _PASS,
    # At the surface, under way.
    "transit": "mission transit vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "go: heading 90 gear 8 for 3min\n" + _PASS,
    # Legs that ask for nothing below, one after the other.
    "adrift": "mission adrift vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "stand: depth 6 heading 0 gear 4 for 30\nadrift: stop up 0 for 60\n" + _PASS,
    # Down there without a heading that is held.
    "loose": "mission loose vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 10 gear 2 until depth >= 9.5 timeout 3min\n"
    "stand: depth 10 gear 0 for 2min\n" + _PASS,
    # An author who is not to be stopped: uncertain, it goes on.
    "stubborn": "mission stubborn vehicle auv\n" + _HOME
    + "safety radius 1500 time 30min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: heading 0 gear 8 for 3min\non_we_go: depth 5 heading 0 gear 8 for 4min\n" + _PASS
    + "on uncertain -> on_we_go\n",
    # A pool: no fix, and none needed.
    "pool": "mission pool vehicle auv\nstart without fix\n"
    "safety radius 600 time 20min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: heading 0 gear 6 for 60\nup: surface timeout 3min\n",
}  # fmt: skip


@functools.lru_cache(maxsize=len(TEXTS))
def mission_of(text: str) -> Mission:
    return parse(TEXTS[text])
