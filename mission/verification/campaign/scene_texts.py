"""The campaign's own missions: short, each with the one leg that a scene needs, in the commands of
each vehicle that flies it.

What does not live here: the scenes (scenes), shipped missions (missions/).
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
    # To a place and back to where it began, by the estimate alone.
    "home": "mission home vehicle auv\n" + _HOME
    + "safety radius 700 time 20min depth 10 voltage 10\nassume current 0.5\n"
    "dive: depth 5 heading 0 gear 4 until depth >= 4.5 timeout 90\n"
    "out: goto north 90 east 40 depth 5 within 15 gear 8 timeout 4min else up\n"
    "back: goto home depth 5 within 15 gear 8 timeout 4min else up\n" + _PASS,
    # A long way in one direction, which ends by its clock.
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
    # At a depth that is kept above the floor.
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
    # Under water, then a leg that asks for no depth.
    "adrift": "mission adrift vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 6 heading 0 gear 4 until depth >= 5.5 timeout 90\n"
    "stand: depth 6 heading 0 gear 4 for 30\nadrift: stop up 0 for 4min\n" + _PASS,
    # Under water without a heading setpoint.
    "loose": "mission loose vehicle auv\n" + _HOME
    + "safety radius 900 time 30min depth 20 voltage 10\nassume current 0.5\n"
    "dive: depth 10 gear 2 until depth >= 9.5 timeout 3min\n"
    "stand: depth 10 gear 0 for 2min\n" + _PASS,
    # A mission that continues when its position is uncertain.
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


_UP = "up: surface timeout 3min\n"
_DOWN = "dive: down 9 until depth >= {} timeout 90\n"
_LOOSE = f"{_DOWN.format(9.5)}stand: down 5 for 80\n"
_ADRIFT = f"{_DOWN.format(5.5)}stand: down 5 for 30\nadrift: stop up 0 for 4min\n"


def _at_place(name: str, vehicle: str, safety: str, body: str, assume: str = "current 0.5") -> str:
    """Write the text for a vehicle that holds depth and heading, and has fixes at the surface."""
    head = f"mission {name} vehicle {vehicle}\n{_HOME}safety {safety} voltage 12\nassume {assume}\n"
    return f"{head}{body}{_PASS}"


def _held(vehicle: str) -> Mapping[str, str]:
    """Write the texts for boards that hold heading and depth together, or for which the Pi does."""
    dive = "dive: depth {0} heading 0 gear 4 until depth >= {1} timeout 4min\n"
    shallow, near, far = "radius 700 time 20min depth 10", "depth 6 heading", "depth 5 heading"
    wide = "radius 900 time 30min depth 20"
    out = f"out: {near} 0 gear 8 for 60\n"
    texts = {
        "there": (shallow, f"{dive.format(6, 5.5)}{out}back: {near} 180 gear 8 for 60\n"),
        "away": (
            "radius 1000 time 30min depth 10",
            f"{dive.format(5, 4.5)}out: {far} 0 gear 6 for 6min\n",
        ),
        "deep": (wide, f"{dive.format(14, 13.5)}stand: depth 14 heading 0 gear 4 for 4min\n"),
        "adrift": ("radius 900 time 30min depth 24", _ADRIFT),
        "loose": ("radius 900 time 30min depth 45", _LOOSE),
        "lit": (
            "radius 1000 time 30min depth 10",
            f"{dive.format(5, 4.5)}out: {far} 0 gear 4 output {_LIT[vehicle]} for 3min\n",
        ),
        "stubborn": (
            "radius 1000 time 30min depth 10",
            f"{dive.format(5, 4.5)}out: {far} 0 gear 6 for 100\non_we_go: {far} 0 gear 6 for 100\n",
        ),
    }
    made = {name: _at_place(name, vehicle, *text) for name, text in texts.items()}
    made["there"] = made["there"].replace("current 0.5", "current 0.5 start 100")
    made["stubborn"] += "on uncertain -> on_we_go\n"
    pool = made["there"].replace("mission there", "mission pool").replace(_PASS, _UP)
    return made | {"pool": pool.replace(_HOME, "start without fix\n")}


def _pushed(vehicle: str, safety: str, bodies: Mapping[str, str]) -> Mapping[str, str]:
    """Write the texts for a vehicle that knows no place and moves by thrust and time."""
    head = f"vehicle {vehicle}\nstart without fix\nsafety {safety}\nassume current 0 start 0\n"
    return {name: f"mission {name} {head}{body}" for name, body in bodies.items()}


_LIT = {"coreboard": "usbl 1", "mainboard": "led1 70"}
_BODIES = {
    "rov": {
        "there": f"{_DOWN.format(5.5)}out: gear 4 down 5 for 45\n"
        f"back: gear -4 down 5 for 45\n{_UP}",
        "away": f"{_DOWN.format(4.5)}out: gear 3 down 5 for 100\n{_UP}",
        "deep": f"{_DOWN.format(13.5)}stand: down 5 for 80\n{_UP}",
        "loose": f"{_LOOSE}{_UP}",
        "adrift": f"{_ADRIFT}{_UP}",
        "pool": f"{_DOWN.format(4.5)}out: gear 3 down 5 for 60\n{_UP}",
        "lit": f"{_DOWN.format(4.5)}out: gear 3 down 5 output lamp 80 for 100\n{_UP}",
    },
    "robot": {
        "there": "out: gear 6 for 50\nback: gear -6 for 50\n",
        "away": "out: gear 6 for 50\non_and_on: gear 3 for 100\n",
        "lit": "out: gear 3 output gimbal_yaw 30 for 100\n",
        "deep": "out: gear 6 for 60\nspin: gear 0 right 6 for 20\nback: gear 6 for 40\n",
    },
}
ON_BOARDS: Mapping[str, Mapping[str, str]] = {
    "coreboard": _held("coreboard"),
    "rov": _pushed("rov", "time 50min depth 50", _BODIES["rov"]),
    "robot": _pushed("robot", "time 20min", _BODIES["robot"]),
    "mainboard": _held("mainboard"),
}


def texts_of(vehicle: str) -> Mapping[str, str]:
    return ON_BOARDS.get(vehicle, TEXTS)


@functools.cache
def mission_of(text: str, vehicle: str = "auv") -> Mission:
    return parse(texts_of(vehicle)[text])
