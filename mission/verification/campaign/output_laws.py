"""Laws of the outputs beside the motion (R18), by the bytes to a board of documents 002 to 004.

    safe     within 0.5 s of an emergency every reversible output is commanded safe, and stays safe
             while the emergency lasts
    final    an irreversible output is set only by an @AO; or, where the vehicle file arms it, by an
             ascent of 120 s that has gained nothing, or whose gain is unknown: its depth was wrong

The AUV's shipped file names no outputs. What does not live here: who may set what
(mission.engine.outputs).
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from typing import Any

from mission.engine.outputs import GAINS, WITHIN
from mission.model import Tx
from mission.model.regions import EMERGENCY
from mission.model.vehicle import Output
from mission.onboard.runtime.runtime import VEHICLE
from mission.verification.campaign.depth_laws import DEPTH_FAULTS
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.story import SAME, Stay, Story
from mission.verification.campaign.surface_laws import UNLAWFUL, UNSENT
from protocol.framing import Frame
from protocol.tolerances import Tolerances
from protocol.vehicles import link
from protocol.vehicles.robot_outputs import GIMBAL

SAFE_S = 0.5  # s
_ERROR = 1.0  # m: error of a depth reading
_AO = re.compile(rb"@AO,(\w+),")
Levels = Mapping[str, float]  # by channel
Said = tuple[float, Levels]
_CARRIED = {
    "coreboard": "coreboard.pc_to_main",
    "rov": "rov.down",
    "robot": "robot.down",
    "mainboard": "coreboard.main_to_sensor",
}


def output_laws(story: Story) -> Iterator[Violation]:
    if story.vehicle.codec not in _CARRIED or not story.vehicle.outputs:
        return
    said = list(_said(story))
    for stay in story.stays:
        if stay.state.startswith(EMERGENCY):
            yield from _not_safe(story, stay, said)
    for output in story.vehicle.outputs:
        if output.irreversible:
            yield from _not_asked(story, output, said)


def _said(story: Story) -> Iterator[Said]:
    """Yield the levels that each frame to the vehicle sets, by channel."""
    name = story.vehicle.codec
    tolerances = Tolerances.parse(story.vehicle.tolerances)
    channels = {output.channel for output in story.vehicle.outputs}

    @functools.lru_cache(4096)
    def read(data: bytes) -> Levels:
        found = link(_CARRIED[name]).framer(tolerances).receive(data, 0.0)
        frames = (frame.values() for frame in found if isinstance(frame, Frame))
        said = (level for values in frames for level in _levels(name, values))
        return {channel: level for channel, level in said if channel in channels}

    for event in story.trial.events:
        if isinstance(event, Tx) and event.link == VEHICLE and (levels := read(event.data)):
            yield event.t, levels


def _levels(name: str, values: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    if name == "robot":
        yield from _of_robot(values)
        return
    for field, value in values.items():
        if field == "passthrough":
            yield from ((f"{field}{n}", byte) for n, byte in enumerate(bytes.fromhex(value), 1))
        elif isinstance(value, int | float):
            yield from ((field, value), (f"{field}_on", value))


def _of_robot(values: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """The gimbal's levels; the shipped file has no safe values for the power module."""
    of = values["address"], values["command"]
    if of in ((GIMBAL, 0), (GIMBAL, 2)):
        for axis in ("yaw", "pitch"):
            yield f"gimbal_{axis}_deg", values.get(f"{axis}_cdeg", 0) / 100.0
    for code, name in ((1, "video"), (3, "zoom")):
        if of == (GIMBAL, code):
            yield name, values[name]


def _not_safe(story: Story, stay: Stay, said: list[Said]) -> Iterator[Violation]:
    """Judge each output's last level in ``SAFE_S``, and all later ones in the emergency."""
    by = stay.begin + SAFE_S
    if stay.end < by or story.hindered(stay.begin - SAFE_S, by):
        return
    for output in story.vehicle.outputs:
        told = [(t, levels[output.channel]) for t, levels in said if output.channel in levels]
        last = [level for t, level in told if t <= by][-1:]
        later = [level for t, level in told if by < t < stay.end]
        wrong = next((v for v in (*last, *later) if _differs(v, output.safe)), None)
        if wrong is not None and not output.irreversible:
            says = f"{output.name} is {wrong:g} in {stay.state}, safe is {output.safe:g}"
            yield Violation(UNSENT, by, says)


def _not_asked(story: Story, output: Output, said: list[Said]) -> Iterator[Violation]:
    """Judge the first frame that sets the output."""
    told = ((t, levels[output.channel]) for t, levels in said if output.channel in levels)
    at = next((t for t, level in told if _differs(level, output.safe)), None)
    if at is None or _ordered(story, output, at):
        return
    if output.ascent is None or not _in_vain(story, at):
        yield Violation(UNLAWFUL, at, f"{output.name} is set, and nothing asked for it")


def _ordered(story: Story, output: Output, t: float) -> bool:
    words = (name for s in story.said if s.t <= t for name in _AO.findall(s.data))
    return output.name.encode() in words


def _in_vain(story: Story, t: float) -> bool:
    """Whether an ascent has lasted for the time without a gain, or nobody could know one (R18).

    A gain counts by the true depth, beyond the error of a reading, and only as far as reports were
    taken: between them, and after the last one, the depth is unknown.
    """
    since = t - WITHIN
    climbs = all(s.ascends for s in story.stays if s.begin < t and s.end > since + SAME)
    unknown = story.faulty(DEPTH_FAULTS, since, t)
    return climbs and (unknown or _gain(story, since, t) < GAINS + _ERROR)


def _gain(story: Story, since: float, t: float) -> float:
    """Return how far the vehicle rose by its reports, m; one of before counts until it is stale."""
    told = [report.t for report in story.told_in(since - story.vehicle.stale_after, t)]
    return story.depth(max(told[0], since)) - story.depth(told[-1]) if told else 0.0


def _differs(level: float, safe: float) -> bool:
    return abs(level - safe) > 0.01
