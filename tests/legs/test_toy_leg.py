"""A leg type is one file: this one has a toy that nobody else knows, and it is seen everywhere."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Self

import jsonschema
import pytest
import yaml
from click.testing import CliRunner
from contracts import keep

from mission.analysis.replay.replay import replay
from mission.authoring.check import check_mission
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.diff.changes import changes
from mission.authoring.graph.formats import FORMATS
from mission.authoring.graph.outline import outline
from mission.authoring.language import MissionErrors, digest, parse, to_lines, to_yaml
from mission.authoring.language.manual import PARTS
from mission.authoring.language.schema import schema
from mission.cli import main
from mission.legs import LEGS, LegType, Track, View
from mission.legs.base import WAY, Author
from mission.legs.guidance import STEERS
from mission.legs.words import Head, Measure, Shape, Spot
from mission.model import Axis, LegKind, Local, Mission, Place
from mission.model.shipped import load_vehicle
from mission.onboard.runtime.records import TX, ListRecorder
from mission.verification.campaign.generated import generate
from mission.verification.campaign.withheld import missions
from mission.verification.simulation.flight import fly
from protocol.messages import Setpoint


@dataclass(frozen=True, slots=True)
class Weave(LegKind):
    """``tacks`` times ``each`` s to one side and the other (``sway``, rad) of the way it had."""

    tacks: int
    sway: float
    each: float
    toward: Place | None


@dataclass(frozen=True, slots=True)
class Plunge(LegKind):
    pass


class Weaver:
    def __init__(self, kind: Weave, base: Setpoint, view: View) -> None:
        self.kind, self.base, self.entered = kind, base, view.now
        self.ahead = view.estimate.heading or 0.0 if view.estimate else 0.0

    def setpoint(self, view: View) -> Setpoint:
        side = 1.0 if int((view.now - self.entered) / self.kind.each) % 2 == 0 else -1.0
        return replace(self.base, heading=(self.ahead + side * self.kind.sway) % math.tau)

    def finished(self, view: View) -> bool:
        return view.now - self.entered >= self.kind.tacks * self.kind.each

    def track(self, view: View) -> Track | None:
        return None

    def clone(self) -> Self:
        return copy.copy(self)


def draw(author: Author) -> str:
    return f"weave {author.rng.randint(2, 6)} sway 20 gear 6{author.way()} {author.timeout()}"


WEAVE = LegType(
    name="weave",
    kind=Weave,
    description="to one side and the other, so many times",
    head=Head(Shape.COUNT, "tacks"),
    clauses=(
        Measure("sway", "deg", 1, 80, "how far to each side", example="20"),
        Measure("each", "s", 1, 600, "how long a tack is", usual=10.0),
        Spot("toward", "toward", "where it leads"),
    ),
    begin=Weaver,
    steers=STEERS,
    needs=frozenset({"heading"}),
    ends=True,
    makes_way=True,
    fault=lambda kind: "" if kind.tacks < 100 else "nobody weaves that often",
    places=lambda kind: (kind.toward,) if kind.toward is not None else (),
    shown=lambda kind: f"weave {kind.tacks} times",
    done=lambda kind: "woven",
    draws=(draw,) * 20,
    trials=(f"a: {WAY} for 10\nb: weave 3 sway 30 gear 6 timeout 60",),
)
VEHICLE = load_vehicle("auv")
HEAD = "mission toy vehicle auv\nhome 30.28 120.15\nsafety radius 400 time 30min depth 20\n"
LEG = "a: weave 4 sway 20 each 8 toward north 100 east 0 depth 3 gear 6 timeout 120"


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    with LEGS.registered(WEAVE):
        yield


def mission(leg: str = LEG) -> Mission:
    return parse(f"{HEAD}dive: heading 0 gear 6 depth 3 for 20\n{leg}\n")


def chart(leg: str = LEG):
    return compile_mission(mission(leg), VEHICLE, digest(mission(leg)))


def test_it_is_parsed_from_both_texts_and_written_as_both() -> None:
    made = mission()
    kind = Weave(4, math.radians(20), 8.0, Local(100.0, 0.0))
    assert made.body[1].kind == kind
    assert parse(to_lines(made)) == parse(to_yaml(made)) == made
    assert "weave: 4, sway: 20 deg, each: 8 s, toward: north 100 east 0" in to_yaml(made)
    assert mission("a: weave 2 sway 5 gear 6 timeout 60").body[1].kind == Weave(
        2, math.radians(5), 10.0, None
    )


@pytest.mark.parametrize(
    ("leg", "rule", "says"),
    [
        ("a: weave 2 gear 6 timeout 60", "missing-word", "weave needs sway"),
        ("a: weave 2 sway 81 gear 6 timeout 60", "range", "out of range"),
        ("a: weave 2 sway 5 heading 3 timeout 60", "steered", "weave sets heading itself"),
        ("a: weave 2 sway 5 gear -6 timeout 60", "no-way", "weave never arrives"),
        ("a: goto home sway 5 timeout 60", "foreign-word", "goto has no sway"),
        ("a: waeve 2 sway 5 timeout 60", "unknown-word", "unknown word 'waeve'"),
        ("param weave 3", "taken-name", "weave is a word"),
    ],
)
def test_what_is_wrong_with_it_is_said_in_its_words(leg: str, rule: str, says: str) -> None:
    with pytest.raises(MissionErrors) as caught:
        mission(leg)
    assert says in str(caught.value)
    assert rule in {problem.code for problem in caught.value.diagnostics}


def test_it_is_in_the_schema_and_its_yaml_fits() -> None:
    validator = jsonschema.Draft7Validator(schema())
    assert schema()["definitions"]["leg"]["dependencies"]["weave"] == ["sway"]
    text = to_yaml(mission())
    assert not list(validator.iter_errors(yaml.safe_load(text)))
    broken = yaml.safe_load(text.replace("sway: 20 deg", "sway: 20 kg"))
    assert list(validator.iter_errors(broken))


def test_it_is_compiled_and_checked() -> None:
    report = check_mission(chart(), VEHICLE)
    assert report.ok, report.refusals
    far = "a: weave 90 sway 20 each 60 gear 12 timeout 20min"
    assert {r.code for r in check_mission(chart(far), VEHICLE).refusals} == {"radius"}
    with pytest.raises(MissionErrors, match="nobody weaves"):
        chart("a: weave 100 sway 20 gear 6 timeout 60")


def test_what_its_row_does_not_bound_the_check_takes_for_unbounded() -> None:
    """A leg type that steers the depth and says not to which may go as deep as it can dive."""
    plunge = LegType("plunge", Plunge, "down", begin=Weaver, steers=frozenset({Axis.VERTICAL}))
    with LEGS.registered(plunge):
        asked = chart("a: plunge heading 0 gear 0 timeout 9min")
        assert {r.code for r in check_mission(asked, VEHICLE).refusals} == {"depth"}


@pytest.mark.parametrize("suffix", [".svg", ".html", ".mmd", ".dot", ".json", ".scxml"])
def test_it_is_drawn(suffix: str) -> None:
    drawn = FORMATS[suffix].draw(outline(chart()), True).decode()
    assert "weave" in drawn or suffix == ".scxml"  # which has the states alone
    if suffix == ".json":
        state = next(s for s in json.loads(drawn)["states"] if s["path"] == "autonomous/a")
        assert state["kind"] == "weave"
        assert state["parameters"]["tacks"] == 4
    if suffix in (".svg", ".mmd", ".dot"):
        assert "woven" in drawn


def test_a_change_of_it_is_told() -> None:
    before, after = chart(), chart(LEG.replace("sway 20", "sway 25"))
    (row,) = changes(before, after, (VEHICLE, VEHICLE)).rows
    assert row.places == ("a",)
    assert ("sway 20 deg" in row.before, "sway 25 deg" in row.after) == (True, True)


def test_it_is_flown_recorded_and_replayed_to_the_bit() -> None:
    recorder = ListRecorder()
    flight = fly(mission(), VEHICLE, seed=3, recorder=recorder)
    assert [(leg.name, leg.by) for leg in flight.legs[:2]] == [("dive", "for"), ("a", "end")]
    assert flight.legs[1].left - flight.legs[1].entered == pytest.approx(32.0, abs=1.0)
    sent = [record.payload for record in recorder.of(TX)]
    assert sum(b"@ZAH" in data for data in sent) >= 4
    assert replay(recorder.records).identical


def test_it_is_listed_in_the_manual() -> None:
    assert (
        "| `weave` | a count | `sway` | `each`, `toward` | to one side and the other, so many times |"
        in PARTS["kinds"]()
    )
    assert "| `each` | s | 1 to 600 | how long a tack is |" in PARTS["measures"]()
    assert "`toward`" in PARTS["measures"]()
    assert "weave" in PARTS["grammar"]()


def test_it_keeps_the_contract_of_legs() -> None:
    keep("legs", WEAVE)


def test_it_is_drawn_at_random_and_flown_with_what_it_waits_for_withheld() -> None:
    assert any("weave" in generate(0, number, VEHICLE).text for number in range(12))
    assert ("weave", WEAVE.trials[0]) in set(missions())


def test_every_command_knows_it(tmp_path) -> None:
    path = tmp_path / "toy.mission"
    path.write_text(to_lines(mission()), encoding="utf-8")
    for words in (["check"], ["graph", "-o", str(tmp_path / "toy.svg")], ["simulate"]):
        ran = CliRunner().invoke(main, [*words, str(path)])
        assert ran.exit_code == 0, (words, ran.output)


def test_what_contradicts_a_leg_type_that_is_there_is_refused() -> None:
    again = replace(WEAVE, clauses=(Measure("radius", "m", 2, 9, "another one"),), kind=LegKind)
    for row, why in ((WEAVE, "registered already"), (again, "weave"),
                     (replace(again, name="toycoil"), "radius")):  # fmt: skip
        with pytest.raises(ValueError, match=why):
            LEGS.register(row)
