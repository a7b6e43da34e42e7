"""Which scenes are staged on which vehicle, and how they differ there.

    AUV        every scene, as it is drawn
    a board    of documents 002 to 004: the scenes that can happen to it. A fault that it cannot
               have is replaced by a similar one (LIKE), or left out where that changes nothing. A
               robot's stick sends ahead and back where others send down and up

A scene that is not staged has a reason (why_not).

What does not live here: the scenes (scenes), their missions in the commands of each vehicle
(scene_texts).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Mapping
from dataclasses import replace
from random import Random

from links.simulated.board_faults import OF_BOARDS
from links.simulated.fault import Fault
from links.simulated.faults import FAULTS
from links.simulated.settings import FaultEvent
from mission.verification.campaign.scene import Scene
from mission.verification.campaign.scene_texts import ON_BOARDS
from mission.verification.campaign.scenes import ON_BOARDS_ALONE, SCENES
from mission.verification.rig.acts import MODEM, Disturbance
from protocol.modem import Sender, wrap

# Faults of the AUV, and what a board has instead; "": without it the scene is the same there.
LIKE: Mapping[str, str] = {
    "ack_lost": "command_lost",
    "stm32_restart": "command_lost",
    "depth_full_scale": "depth_frozen",
    "depth_silent": "depth_frozen",
    "depth_absurd": "depth_frozen",
    "deaf_to_u": "",
    "gps_lost": "",
    "heavy": "",  # of the robot
}
_M = re.compile(rb"@MM[^@$]+\$")
# Reasons why not; unseen gives them for rules, too.
NO_RECEIVER = "it has no receiver of its own"
NO_SUCH_FAULT = "its simulated board has no such fault of a sensor"
NO_PLACE = "it knows no place"
HOLDS_NOTHING = "nothing holds a depth before its signs are confirmed"
ON_LAND = "it drives on land"
NO_HEADING_AT_SURFACE = "its place is known at the surface alone, where its board holds no heading"
UNKNOWN_AT_REST = (
    "fixes alone tell that a depth is frozen at rest, and it has no receiver of its own"
)
NO_BATTERY, NO_LEAK = "it reports no battery", "it reports no leak"
_WORDS = "its board repeats a whole frame, and answers nothing: no single word is lost or refused"
_UNPROVED = "without a place nothing but its depth can prove the surface: it surfaces for ever"
_SINKING = (
    *("heavy_for_ever", "heavy_after_x", "neutral_after_x", "heavy_when_surfaced"),
    *("heavy_when_idle", "heavy_when_waiting", "heavy_with_auto_closed", "unliftable"),
    *("sinks_in_a_hold", "sinks_adrift", "weak_thrusters"),
    *("capsized", "capsized_and_heavy", "capsized_blind", "blind", "surfacing_blind"),
    *("shallow_depth", "cleared_below", "started_below", "restarted_frozen"),
    *("held_and_then", "restarted_with_auto_closed", "started_from_stick"),
)
_ON_ALL: Mapping[str, tuple[str, ...]] = {
    _WORDS: (
        *("deaf_to_w", "deaf_to_u", "dives_until_up", "dives_until_stop", "obeys_late"),
        *("garbled_x", "turns_after_a_stop", "refused", "no_answers", "answered_by_another"),
        *("heavy_beside", "heavy_and_clogged", "held_up", "slider", "busy_slider"),
    ),
    NO_RECEIVER: (
        *("stuck_receiver", "wandering_receiver", "blind_and_wandering", "heavy_and_wandering"),
        "heavy_and_late",
        *("clogged_at_the_surface", "lying_second"),
    ),
    NO_SUCH_FAULT: (
        *("clogged", "wrong_compass", "loose_compass", "blind_compass", "full_scale_roll"),
        *("blind_altimeter", "blind_above_the_bottom", "lying_log", "lying_place"),
        "restarted_at_full_scale",
    ),
    UNKNOWN_AT_REST: ("sinks_unseen",),
}
_NOT_ON: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "coreboard": {NO_HEADING_AT_SURFACE: ("onto_the_shoal",)},
    "mainboard": {NO_HEADING_AT_SURFACE: ("onto_the_shoal",)},
    "rov": {
        NO_PLACE: ("small_radius", "swept_away", "onto_the_shoal"),
        HOLDS_NOTHING: ("sinks_in_a_hold", "weak_thrusters"),
        NO_BATTERY: ("low_battery",),
        NO_LEAK: ("leak",),
        _UNPROVED: ("surfacing_blind", "capsized_blind", "restarted_frozen"),
    },
    "robot": {
        NO_PLACE: ("small_radius", "swept_away", "onto_the_shoal"),
        ON_LAND: _SINKING,
        NO_LEAK: ("leak",),
    },
}


def faults_of(vehicle: str) -> Mapping[str, Fault]:
    """Return the faults that the shipped vehicle of this name can have."""
    return OF_BOARDS.get(vehicle, FAULTS)


def why_not(scene: str, vehicle: str) -> str:
    """Return why a scene is not staged on a vehicle, "" if it is."""
    return not_staged(vehicle).get(scene, "")


@functools.cache
def scenes_of(vehicle: str) -> tuple[str, ...]:
    rows = {**SCENES, **ON_BOARDS_ALONE} if vehicle in ON_BOARDS else SCENES
    return tuple(scene for scene in rows if not why_not(scene, vehicle))


@functools.cache
def not_staged(vehicle: str) -> Mapping[str, str]:
    """Return the scenes that are not staged on a vehicle, with their reasons."""
    if vehicle not in ON_BOARDS:
        return {}
    groups = (*_ON_ALL.items(), *_NOT_ON[vehicle].items())
    return {scene: reason for reason, scenes in groups for scene in scenes}


def staged_on(vehicle: str, name: str, rng: Random) -> Scene:
    """Draw the scene for the vehicle. Raises KeyError for a scene that is not staged there."""
    if name not in scenes_of(vehicle):
        raise KeyError(f"{name} is not staged on {vehicle}: {why_not(name, vehicle)}")
    if vehicle not in ON_BOARDS:
        return SCENES[name].draw(rng)
    scene = {**SCENES, **ON_BOARDS_ALONE}[name].draw(rng)
    known = faults_of(vehicle)
    faults = tuple(f for event in scene.faults if (f := _like(event, known)) is not None)
    said = tuple(_in_words_of(vehicle, d) for d in scene.disturbances)
    return replace(scene, faults=faults, disturbances=said)


def _like(event: FaultEvent, known: Mapping[str, Fault]) -> FaultEvent | None:
    if event.name in known:
        return event
    return replace(event, name=LIKE[event.name]) if LIKE[event.name] else None


def _in_words_of(vehicle: str, said: Disturbance) -> Disturbance:
    if vehicle != "robot":
        return said
    word = _M.search(said.data)
    if word is None:
        return said
    data = word[0].replace(b"@MMD", b"@MMB").replace(b"@MMU", b"@MMF")
    return replace(said, data=wrap(data, Sender.TOPSIDE) if said.link == MODEM else data)
