"""The laws of what is set beside the motion: a sound flight keeps them, a tampered one does not."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest

from links.simulated.settings import Settings
from mission.authoring.language import parse
from mission.model import STOPPED, Step, Tx
from mission.verification.campaign.draw import body_of
from mission.verification.campaign.laws import Violation
from mission.verification.campaign.output_laws import output_laws
from mission.verification.campaign.scene import X, say
from mission.verification.campaign.story import Story
from mission.verification.campaign.surface_laws import UNLAWFUL
from mission.verification.campaign.trial import try_out
from mission.verification.campaign.word_laws import UNSENT
from mission.verification.rig.acts import BOAT, TOPSIDE
from mission.verification.rig.trace import Event, Said, Trace
from mission.verification.rig.vehicle import flown
from protocol.fields import Number
from protocol.tolerances import Tolerances
from protocol.vehicles.coreboard import main_to_sensor

HEAD = "safety time 20min{}\nstart without fix\nassume current 0 start 0\n"
TEXTS = {
    "rov": ("depth 20", "down: down 9 output lamp 80 for 60s\n", b"@AO,servo,-10,$"),
    "robot": ("", "out: gear 3 output gimbal_yaw 30 for 60s\n", b"@AO,zoom,9,$"),
    "mainboard": ("depth 20", "down: down 5 output led1 70 for 60s\n", b"@AO,side_scan,1,$"),
}


@functools.cache
def trace_of(name: str) -> tuple[str, Trace]:
    """Outputs by the mission and by hand, and an X."""
    bounds, leg, by_hand = TEXTS[name]
    head = HEAD.format(f" {bounds}" if bounds else "")
    text = f"mission lit vehicle {name}\n{head}{leg}up: surface timeout 3min\n"
    said = (say(12.0, by_hand), say(18.0, X), say(20.0, by_hand))
    settings = Settings(body=body_of(name))
    return text, try_out(parse(text), flown(name), "documented", 3, settings, said)


def judged(name: str, events: tuple[Event, ...]) -> list[Violation]:
    text, trace = trace_of(name)
    changed = replace(trace, events=events)
    settings = Settings(body=body_of(name))
    return list(output_laws(Story(changed, parse(text), flown(name), "documented", settings)))


def stopped_at(events: tuple[Event, ...]) -> float:
    return next(e.t for e in events if isinstance(e, Step) and STOPPED in e.entered)


def to_board(events: tuple[Event, ...], begin: float, end: float) -> list[Tx]:
    return [e for e in events if isinstance(e, Tx) and e.link == "vehicle" and begin < e.t < end]


@pytest.mark.proof
@pytest.mark.parametrize("name", TEXTS)
def test_a_flight_whose_outputs_are_safe_behind_an_x_keeps_the_law(name: str) -> None:
    events = trace_of(name)[1].events
    assert judged(name, events) == []
    at = stopped_at(events)
    lit = {tx.data for tx in to_board(events, at - 5.0, at)}
    assert lit - {tx.data for tx in to_board(events, at + 0.5, at + 5.0)}, "the outputs were on"


@pytest.mark.parametrize("name", TEXTS)
def test_an_output_that_is_on_in_an_emergency_is_seen(name: str) -> None:
    """What was said before the X is said again 2 s behind it."""
    events = trace_of(name)[1].events
    at = stopped_at(events)
    before = [replace(tx, t=at + 2.0) for tx in to_board(events, 5.0, at - 0.1)]
    found = judged(name, tuple(sorted((*events, *before), key=lambda event: event.t)))
    assert {violation.kind for violation in found} == {UNSENT}
    assert "in emergency/stopped, safe is 0" in found[0].says


def test_an_output_that_is_made_safe_too_late_is_seen() -> None:
    events = trace_of("rov")[1].events
    at = stopped_at(events)
    (*_, lit) = to_board(events, 5.0, at - 0.1)

    def late() -> Iterator[Event]:
        for event in events:
            early = isinstance(event, Tx) and event.link == "vehicle" and at <= event.t < at + 0.7
            yield replace(event, data=lit.data) if early else event

    assert {violation.kind for violation in judged("rov", tuple(late()))} == {UNSENT}


@pytest.mark.parametrize(
    ("said", "kinds"),
    [((), {UNLAWFUL}), ((Said(9.0, TOPSIDE, BOAT, b"@AO,weight,1,$"),), set())],
)
def test_a_drop_weight_is_let_go_by_an_operator_or_not_at_all(
    said: tuple[Said, ...], kinds: set[str]
) -> None:
    events = trace_of("mainboard")[1].events
    board = main_to_sensor(Tolerances())
    known = next(tx for tx in to_board(events, 5.0, 9.0) if board.check(tx.data) is None)
    values = {k: v for k, v in board.decode(known.data).items() if k != "flags"}
    dropped = replace(known, t=10.0, data=board.encode(values | {"drop_weight": 1}))
    mixed = tuple(sorted((*events, *said, dropped), key=lambda event: event.t))
    assert {violation.kind for violation in judged("mainboard", mixed)} == kinds


@pytest.mark.parametrize(
    ("frozen", "told", "kinds"),
    [
        (True, range(20, 160), []),
        (False, range(20, 160), [UNLAWFUL]),
        (False, (), []),
        (False, (20, 28), []),
        (False, range(20, 40), []),
        (False, range(120, 160), [UNLAWFUL]),
        (False, range(140, 160), []),
        (False, (30, 149), [UNLAWFUL]),
    ],
)
def test_an_ascent_that_rose_lets_a_weight_go_only_where_nobody_could_know_it(
    frozen: bool, told: Sequence[float], kinds: list[str]
) -> None:
    """From 12 m to 3 m in its 120 s; without a believed depth that is no gain (R18).

    ``told``: when reports were taken. As flight 29 of the main board's seed 301: a board that was
    silent for the whole ascent.
    """
    board = main_to_sensor(Tolerances())
    names = (f.name for f in board.fields if isinstance(f, Number))
    values = dict.fromkeys(names, 0) | {"drop_weight": 1, "passthrough": "00" * 16}
    story = SimpleNamespace(
        vehicle=flown("mainboard"),
        trial=SimpleNamespace(events=(Tx(150.0, "vehicle", board.encode(values), ""),)),
        stays=(SimpleNamespace(state="emergency/surfacing", begin=20.0, end=200.0, ascends=True),),
        said=(),
        depth=lambda t: 14.25 - 0.075 * t,
        told_in=lambda begin, end: [SimpleNamespace(t=t) for t in told if begin < t < end],
        faulty=lambda _names, begin, end: frozen and begin < end,
        hindered=lambda _begin, _end: True,
    )
    assert [violation.kind for violation in output_laws(cast(Story, story))] == kinds
