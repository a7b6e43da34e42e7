"""What holds of every row of every table that is made to be added to.

    LAWS["limits"]      the laws of one table, each a function of a row
    keep("limits", TOY) all of them of one row; for a row that one test file has made

tests/test_contracts.py runs them over the rows that there are.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import re
import select
from collections.abc import Callable, Iterator, Mapping
from random import Random
from typing import Any

import pytest
from limit_cases import CASES
from link_pair import LATER, Pair, linked
from patience import LONG, until

from links import LINKS, LinkAddressError, parse_address
from links.base import LinkClosed
from links.simulated.boards import BOARDS, ON_BUS
from links.simulated.fault import Fault
from links.simulated.faults import FAULTS
from links.simulated.settings import FaultEvent, parse_fault
from links.tcp import TcpServer
from mission.authoring.language import parse, to_lines, to_yaml
from mission.authoring.language.manual import PARTS
from mission.authoring.language.schema import schema_text
from mission.engine.limits import LIMITS, Limit, On, Response
from mission.engine.orders import ORDERS, OrderRow
from mission.engine.variables import VARIABLES, Variable
from mission.legs import LEGS, LegType
from mission.legs.words import meaning
from mission.model import AUTONOMOUS, SURFACING, By, NavigationMode
from mission.model.alarms import ALARMS, AlarmRow
from mission.model.plain import UNSAID
from mission.model.shipped import load_vehicle
from mission.verification.campaign.disturbances import INCIDENTS
from mission.verification.campaign.generated import Writer
from mission.verification.campaign.whole_flight import FLIGHT_LAWS, FlightLaw, kinds
from mission.verification.campaign.withheld import missions
from mission.verification.exhaustive.cell import Event
from mission.verification.exhaustive.events import EVENTS, events
from mission.verification.exhaustive.laws import Law
from mission.verification.exhaustive.run import LAWS as CELL_LAWS
from protocol.messages import Ack, Order, Setpoint
from protocol.operator_words import WORDS, OperatorWord
from protocol.reference import reference
from protocol.topside import ConsoleCodec, TopsideCodec, answer, encode
from protocol.vehicles import VEHICLES, VehicleRow, codec

EVERYTHING = bytes(range(256))

# --- legs -----------------------------------------------------------------------------------------


def a_leg_type_says_how_it_is_written_shown_drawn_and_tried(row: LegType) -> None:
    said = {row.head.field, row.until_fix, *(clause.field for clause in row.clauses)} - {""}
    fields = dataclasses.fields(row.kind)
    assert said == {field.name for field in fields if field.metadata != UNSAID}
    assert row.description
    assert row.trials
    for body in row.trials:
        assert row.name in body or row.name == "hold"
    for clause in row.clauses:
        assert re.fullmatch(r"[a-z]+", clause.word)
        assert clause.description
        others = [c for other in LEGS.values() for c in other.clauses if c.word == clause.word]
        assert all(meaning(other) == meaning(clause) for other in others), (
            "one word means one thing"
        )


def what_a_leg_type_draws_or_tries_is_a_mission(row: LegType) -> None:
    """What the check says of it is the campaign's business."""
    for number, draw in itertools.product(range(10), row.draws):
        writer = Writer(Random(number), "drawn", load_vehicle("auv-documented"))
        (leg,) = parse(f"mission m\na: {draw(writer)}\n").body
        assert type(leg.kind) is row.kind  # type: ignore[union-attr]
        assert row.shown(leg.kind) or row.name == "hold"  # type: ignore[union-attr]
        assert row.done(leg.kind)  # type: ignore[union-attr]
    for body in row.trials:
        made = parse(f"mission m\n{body}\n")
        assert parse(to_lines(made)) == parse(to_yaml(made)) == made


def a_leg_type_stands_in_the_schema_and_in_the_manual(row: LegType) -> None:
    assert row.name in schema_text() or row.name == "hold"
    assert row.name in PARTS["kinds"]() or row.name == "hold"


# --- guard variables --------------------------------------------------------------------------------


def a_variable_is_written_in_both_texts_and_tried_with_what_it_waits_for_withheld(
    row: Variable,
) -> None:
    assert (row.name in dict(missions())) == bool(row.trial)
    if row.trial:
        made = parse(f"mission m\na: gear 4 until {row.trial} timeout 60\n")
        assert parse(to_lines(made)) == parse(to_yaml(made)) == made


def a_variable_stands_in_the_schema_and_in_the_manual(row: Variable) -> None:
    assert row.description
    assert row.source
    assert row.max_age > 0.0
    assert row.name in schema_text()
    assert f"| `{row.name}` |" in PARTS["variables"]()


def what_a_variable_draws_is_a_guard_of_it(row: Variable) -> None:
    if row.draw is not None:
        drawn = row.draw(Random(1), 10)
        assert drawn.startswith(row.name)
        parse(f"mission m\na: gear 4 until {drawn} timeout 60\n")


# --- limits ---------------------------------------------------------------------------------------


def _tripped(world: Any, name: str) -> bool:
    """Whether the row, and no other, took the vehicle where it is."""
    left = [s for s in world.steps if s.trigger == "limit" or s.by is By.UNCERTAIN]
    names = {e.trigger for s in left for e in s.evaluations}
    assert names <= {f"limit {name}"}, names
    return bool(left)


def a_limit_trips_a_hair_beyond_its_bound(row: Limit) -> None:
    case = CASES[row.name]
    world = case.begin()
    case.trips(world)
    assert _tripped(world, row.name)
    if row.response is Response.UNCERTAIN:
        assert world.state == f"{AUTONOMOUS}/surface"
    else:
        assert SURFACING in [path for s in world.steps for path in s.entered]
    assert world.engine.reason == f"limit {row.name}: {case.says}"


def a_limit_does_not_trip_at_its_bound_or_a_sample_too_early(row: Limit) -> None:
    case = CASES[row.name]
    for way in (case.short, case.bound):
        world = case.begin()
        way(world)
        assert not _tripped(world, row.name)


def what_is_not_to_be_believed_breaches_no_limit(row: Limit) -> None:
    """Another one may act: there is one for a depth that is not known."""
    if not row.needs or row.on is On.CLOCK or row.name == "depth contradicted":
        return
    case = CASES[row.name]
    world = case.begin()
    for need in row.needs:
        world.nav.doubt[need] = "absurd"
    world.nav.mode = NavigationMode.NONE
    if row.name == "leak":
        world.report = lambda report=world.report, **more: report(**more)._replace(leak=None)  # type: ignore[method-assign]
    case.trips(world)
    taken = {e.trigger for s in world.steps for e in s.evaluations}
    assert f"limit {row.name}" not in taken
    assert row.name not in {found.name for found in world.engine.breaches}


def a_limit_is_tripped_by_an_event_in_every_state(row: Limit) -> None:
    assert row.name in {event.limit for event in events()}


# --- the operator's words ---------------------------------------------------------------------------


def a_word_is_read_as_it_is_written_and_its_acknowledgement_too(word: OperatorWord) -> None:
    assert word.examples
    for raw in word.examples:
        (said,) = TopsideCodec().receive(raw, 0.0)
        assert type(said) is word.message
        assert TopsideCodec().receive(encode(said), 0.0) == [said]
    if word.letter:
        (ack,) = ConsoleCodec().receive(encode(answer(word.code, True, 0.0)), 0.0)
        assert isinstance(ack, Ack)
        assert (ack.group + ack.function, ack.ok) == (word.code, True)


def a_word_stands_in_the_reference_of_the_protocol(word: OperatorWord) -> None:
    assert f"### {word.name}\n" in reference()


def a_word_is_tried_in_every_state(word: OperatorWord) -> None:
    assert word.code in {event.command for event in events()}


def a_word_is_said_by_an_operator_under_stress(word: OperatorWord) -> None:
    draw = INCIDENTS["operator_under_stress"].draw
    said = {d.data[:3] for n in range(40) for d in draw(Random(n), ("wait 10s",))}
    assert b"@" + word.code.encode() in said


def an_order_is_a_word_and_is_refused_where_it_is_not_allowed(row: OrderRow) -> None:
    assert WORDS[row.word.message] is row.word

    class Elsewhere:
        region = "nowhere"

    if row.regions:
        assert not row.obey(Elsewhere(), None).accepted  # type: ignore[arg-type]


# --- links ------------------------------------------------------------------------------------------


def a_scheme_takes_its_own_example_and_no_unknown_option(scheme: str) -> None:
    example = LINKS[scheme].example
    assert parse_address(example).scheme == scheme
    glue = "&" if "?" in example else "?"
    with pytest.raises(LinkAddressError, match="speed"):
        parse_address(f"{example}{glue}speed=1")


def bytes_of_every_value_pass_both_ways(scheme: str) -> None:
    with linked(scheme) as pair:
        for sender, receiver in ((pair.near, pair.far), (pair.far, pair.near)):
            pair.send(sender, EVERYTHING)
            assert pair.read(receiver, len(EVERYTHING)) == EVERYTHING


def receiving_never_waits(scheme: str) -> None:
    """Where the file is the link's own, it says so itself; a listening one asks a selector, and
    python-can does."""
    with linked(scheme) as pair:
        assert pair.receive(pair.near) == []
        fd = pair.near.fileno()
        assert (
            fd < 0 or isinstance(pair.near, TcpServer) or scheme == "can" or not os.get_blocking(fd)
        )


def what_arrives_bears_the_name_and_a_time_up_to_the_asking(scheme: str) -> None:
    with linked(scheme) as pair:
        pair.send(pair.far, b"@NI$", 7.0)
        found: list[Any] = []
        until(lambda: bool(found.extend(pair.receive(pair.near, 7.0 + LATER)) or found))
        ((t, link, data),) = [(rx.t, rx.link, rx.data) for rx in found]
        assert (link, data) == ("near", b"@NI$")
        assert 7.0 <= t <= 7.0 + LATER


def the_event_loop_is_told_when_something_comes(scheme: str) -> None:
    """A file that it can watch; where there is none, a time that can be foretold, but for buses
    within a process, which are asked each time."""
    with linked(scheme) as pair:
        _is_told(pair, scheme)


def _is_told(pair: Pair, scheme: str) -> None:
    fd = pair.near.fileno()
    pair.send(pair.far, b"x", 3.0)
    if fd >= 0:
        assert select.select([fd], [], [], LONG)[0] == [fd]
    elif scheme != "can":
        coming = pair.near.next_event()
        assert coming is not None
        assert 3.0 <= coming <= 3.0 + LATER


def a_closed_link_says_so_and_may_be_closed_twice(scheme: str) -> None:
    with linked(scheme) as pair:
        pair.near.close()
        pair.near.close()
        assert pair.near.fileno() == -1
        with pytest.raises(LinkClosed):
            pair.near.receive(0.0)
        with pytest.raises(LinkClosed):
            pair.send(pair.near, b"x")


# --- vehicles, and what goes wrong with them --------------------------------------------------------


def a_vehicle_stops_and_says_nothing_by_itself(row: VehicleRow) -> None:
    for dialect in row.dialects:
        made = codec(row.name, dialect, {})
        assert made.next_timer() is None
        assert made.receive(b"", 0.0) == []
        assert made.flush(1.0) == []
        assert all(isinstance(f, bytes) and f for f in made.encode(Order.STOP))
        assert made.encode(Setpoint())


def the_ways_of_an_ascent_are_different_bytes(row: VehicleRow) -> None:
    """R7: a way that differs in name alone would be tried twice, and the way that helps never."""
    for dialect in row.dialects:
        encode_ = codec(row.name, dialect, {}).encode
        downward = [] if row.name == "robot" else [Setpoint(heave=1.0)]
        said = [tuple(encode_(way)) for way in (*row.ways, *downward)]
        assert len(set(said)) == len(said)
    assert row.ways[0] is Order.SURFACE
    assert row.name == "robot" or row.ways[-1] is Order.STOP


def a_vehicle_stands_in_the_reference_and_has_a_simulated_board(row: VehicleRow) -> None:
    shown = reference()
    assert all(f"### {name}\n" in shown for name, _ in row.examples)
    assert row.name == "auv" or row.name in BOARDS or row.name in ON_BUS


def a_fault_says_what_it_does_and_how_long(name: str) -> None:
    row: Fault = FAULTS[name]
    assert row.says
    assert row.duration > 0.0
    assert bool(row.unit) == (row.value != 0.0)
    assert parse_fault(f"{name}@12+3") == FaultEvent(name, 12.0, 3.0)


def an_incident_is_drawn_and_nothing_of_it_is_before_it_begins(name: str) -> None:
    row = INCIDENTS[name]
    assert row.says
    for number in range(10):
        drawn = row.draw(Random(number), ("mission m vehicle auv", "wait 10s"))
        assert drawn
        assert all(disturbance.after >= 0.0 for disturbance in drawn)


def an_alarm_says_what_to_do(row: AlarmRow) -> None:
    assert row.name
    assert row.level
    assert row.do


# --- laws and events --------------------------------------------------------------------------------


def a_law_of_cells_names_its_source(law: Law) -> None:
    assert re.match(r"R\d+|design: the states|as built$|E-", law.source)


def an_event_breaches_a_limit_that_there_is(event: Event) -> None:
    assert event.limit in {"", *LIMITS}
    assert event.causes == event.causes - {""}


def what_a_law_of_flights_finds_is_counted(law: FlightLaw) -> None:
    assert law.kinds
    assert set(law.kinds) <= set(kinds())


# --- all of them --------------------------------------------------------------------------------------

Contract = tuple[Callable[[], Mapping[str, Any]], tuple[Callable[[Any], None], ...]]


def _named(table: Mapping[Any, Any], name: Callable[[Any], str]) -> Callable[[], Mapping[str, Any]]:
    return lambda: {name(row): row for row in table.values()}


def _keys(table: Mapping[str, Any]) -> Callable[[], Mapping[str, Any]]:
    """Of tables whose rows do not know their names."""
    return lambda: {name: name for name in table}


LAWS: Mapping[str, Contract] = {
    "legs": (
        _named(LEGS, lambda row: row.name),
        (
            a_leg_type_says_how_it_is_written_shown_drawn_and_tried,
            what_a_leg_type_draws_or_tries_is_a_mission,
            a_leg_type_stands_in_the_schema_and_in_the_manual,
        ),
    ),
    "variables": (
        _named(VARIABLES, lambda row: row.name),
        (
            a_variable_is_written_in_both_texts_and_tried_with_what_it_waits_for_withheld,
            a_variable_stands_in_the_schema_and_in_the_manual,
            what_a_variable_draws_is_a_guard_of_it,
        ),
    ),
    "limits": (
        _named(LIMITS, lambda row: row.name),
        (
            a_limit_trips_a_hair_beyond_its_bound,
            a_limit_does_not_trip_at_its_bound_or_a_sample_too_early,
            what_is_not_to_be_believed_breaches_no_limit,
            a_limit_is_tripped_by_an_event_in_every_state,
        ),
    ),
    "words": (
        _named(WORDS, lambda word: word.code),
        (
            a_word_is_read_as_it_is_written_and_its_acknowledgement_too,
            a_word_stands_in_the_reference_of_the_protocol,
            a_word_is_tried_in_every_state,
            a_word_is_said_by_an_operator_under_stress,
        ),
    ),
    "orders": (
        _named(ORDERS, lambda row: row.word.code),
        (an_order_is_a_word_and_is_refused_where_it_is_not_allowed,),
    ),
    "links": (
        _keys(LINKS),
        (
            a_scheme_takes_its_own_example_and_no_unknown_option,
            bytes_of_every_value_pass_both_ways,
            receiving_never_waits,
            what_arrives_bears_the_name_and_a_time_up_to_the_asking,
            the_event_loop_is_told_when_something_comes,
            a_closed_link_says_so_and_may_be_closed_twice,
        ),
    ),
    "vehicles": (
        _named(VEHICLES, lambda row: row.name),
        (
            a_vehicle_stops_and_says_nothing_by_itself,
            the_ways_of_an_ascent_are_different_bytes,
            a_vehicle_stands_in_the_reference_and_has_a_simulated_board,
        ),
    ),
    "faults": (_keys(FAULTS), (a_fault_says_what_it_does_and_how_long,)),
    "incidents": (
        _keys(INCIDENTS),
        (an_incident_is_drawn_and_nothing_of_it_is_before_it_begins,),
    ),
    "alarms": (_named(ALARMS, lambda row: row.name), (an_alarm_says_what_to_do,)),
    "laws of cells": (_named(CELL_LAWS, lambda law: law.name), (a_law_of_cells_names_its_source,)),
    "events": (
        _named(EVENTS, lambda event: event.name),
        (an_event_breaches_a_limit_that_there_is,),
    ),
    "laws of flights": (
        _named(FLIGHT_LAWS, lambda law: law.name),
        (what_a_law_of_flights_finds_is_counted,),
    ),
}


def keep(table: str, row: Any) -> None:
    """Every law of the table, of this row."""
    for law in LAWS[table][1]:
        law(row)


def all_of_them() -> Iterator[tuple[str, Callable[[Any], None], Any]]:
    """Name, law and row, of every row of every table."""
    for table, (rows, laws) in LAWS.items():
        for name, row in rows().items():
            for law in laws:
                yield f"{table}, {name}: {law.__name__}", law, row
