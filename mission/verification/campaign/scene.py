"""What a scene is, and the helpers in which scenes are written.

What does not live here: the scenes (scenes and its two parts), their missions (scene_texts).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from links.simulated.settings import FaultEvent
from mission.verification.campaign.trial import FOREVER
from mission.verification.rig.acts import BOAT, OTHER_BOAT, TOPSIDE, Act, Disturbance

STARTED = 6.0  # s: about when a scene's mission begins
DOWN = STARTED + 30.0  # s: at depth, in every mission but the transit
X, W, AA, AC = b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@AC$"


@dataclass(frozen=True, slots=True)
class Scene:
    """A scene as drawn. ``silence``: the topside's longest, s; ``batteries``: they are reported."""

    text: str
    faults: tuple[FaultEvent, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    silence: float | None = None
    batteries: bool = False
    current: float | None = None  # m/s, towards the north


@dataclass(frozen=True, slots=True)
class SceneRow:
    says: str
    draw: Callable[[Random], Scene]


def say(t: float, data: bytes, address: str = BOAT) -> Disturbance:
    return Disturbance(t, Act.SAY, data, TOPSIDE, address)


def joins(t: float = 4.0) -> Disturbance:
    return Disturbance(t, Act.JOIN, b"", TOPSIDE, OTHER_BOAT)


def repeated(
    begin: float, end: float, every: float, data: bytes, who: str = BOAT
) -> list[Disturbance]:
    return [say(begin + every * i, data, who) for i in range(int((end - begin) / every) + 1)]


def fault(
    name: str, begin: float, duration: float = FOREVER, value: float | None = None
) -> FaultEvent:
    return FaultEvent(name, round(begin, 1), round(duration, 1), value)


def heavy(rng: Random, begin: float, duration: float = FOREVER) -> FaultEvent:
    """Draw a weight: heavier than neutral, and within what the thrusters can lift."""
    return fault("heavy", begin, duration, round(rng.uniform(20.0, 45.0), 1))
