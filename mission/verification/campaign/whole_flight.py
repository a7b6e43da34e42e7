"""What may not happen at any instant of a disturbed flight, by the truth and by the bytes.

    sunk        under water or sinking, and not on its way up in time (depth_laws)
    unanswered  a limit truly passed, and no response in time (limit_laws, leg_laws, area_laws)
    unsent      a set, a stop or a safe output did not leave (word_laws, line_laws, output_laws)
    unlawful    a move that the rules forbid (word_laws, surface_laws, status_laws, clear_laws,
                output_laws)

A law is a row of FLIGHT_LAWS. Its violations are counted by its kinds.

The laws are written from the rules (docs/rules.md) alone, never from what the engine does. What
does not live here: the end of a flight and its bounds (laws), who asked for a byte (audit).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from links.simulated.settings import Settings
from mission.model import Mission
from mission.model.tables import Table
from mission.model.vehicle import Vehicle
from mission.verification.campaign.area_laws import area_laws
from mission.verification.campaign.clear_laws import clear_laws
from mission.verification.campaign.depth_laws import SUNK, depth_laws
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.leg_laws import leg_laws
from mission.verification.campaign.limit_laws import UNANSWERED, limit_laws
from mission.verification.campaign.line_laws import line_laws
from mission.verification.campaign.output_laws import output_laws
from mission.verification.campaign.status_laws import status_laws
from mission.verification.campaign.story import Story
from mission.verification.campaign.surface_laws import UNLAWFUL, UNSENT, surface_laws
from mission.verification.campaign.word_laws import word_laws
from mission.verification.rig.trace import Trace


@dataclass(frozen=True, slots=True)
class FlightLaw:
    """``ask`` yields the violations of a flight; ``kinds`` are their kinds."""

    name: str
    kinds: tuple[str, ...]
    ask: Callable[[Story], Iterator[Violation]]


FLIGHT_LAWS: Table[str, FlightLaw] = Table(
    lambda law: law.name,
    (
        FlightLaw("areas", (UNANSWERED,), area_laws),
        FlightLaw("clear", (UNLAWFUL,), clear_laws),
        FlightLaw("depth", (SUNK,), depth_laws),
        FlightLaw("legs", (UNANSWERED,), leg_laws),
        FlightLaw("limits", (UNANSWERED,), limit_laws),
        FlightLaw("line", (UNSENT,), line_laws),
        FlightLaw("outputs", (UNSENT, UNLAWFUL), output_laws),
        FlightLaw("status", (UNLAWFUL,), status_laws),
        FlightLaw("surface", (UNLAWFUL,), surface_laws),
        FlightLaw("words", (UNSENT, UNLAWFUL), word_laws),
    ),
)
_KINDS = (SUNK, UNANSWERED, UNSENT, UNLAWFUL)  # in the order of reports


def kinds() -> tuple[str, ...]:
    """Return the kinds of all laws, each once."""
    return tuple(dict.fromkeys((*_KINDS, *(k for law in FLIGHT_LAWS.values() for k in law.kinds))))


def throughout(
    trial: Trace,
    mission: Mission,
    vehicle: Vehicle,
    profile: str,
    settings: Settings,
    silence: float | None = None,
) -> Iterator[Violation]:
    """Yield all violations of a flight; ``silence``: how long the topside may be silent, s."""
    if trial.raised:
        return
    story = Story(trial, mission, vehicle, profile, settings, silence)
    for law in FLIGHT_LAWS.values():
        yield from law.ask(story)
