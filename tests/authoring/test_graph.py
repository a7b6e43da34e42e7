"""Laws of the state graph: every format tells the same chart, and all of it."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import pytest
from graph_charts import chart

from mission.authoring.graph import canvas
from mission.authoring.graph.dot import dot
from mission.authoring.graph.formats import FORMATS
from mission.authoring.graph.mermaid import mermaid
from mission.authoring.graph.outline import outline
from mission.authoring.graph.raster import NoFont, fonts
from mission.authoring.graph.svg import svg
from mission.authoring.prepare import prepare
from mission.engine.machine import Machine
from mission.model import AUTONOMOUS, IMPLICIT_SURFACE

SVG = "{http://www.w3.org/2000/svg}"


def texts(drawing: str) -> list[str]:
    return ["".join(node.itertext()) for node in ET.fromstring(drawing).iter(f"{SVG}text")]


@pytest.mark.parametrize("row", FORMATS.values(), ids=lambda row: row.suffix)
@pytest.mark.parametrize("depth", [None, 1])
def test_every_format_draws_every_chart_the_same_way_twice(row: Any, depth: int | None) -> None:
    charts = [chart(1, 1, 0), chart(0, 0, 1), chart(2, 4, 5, repeat=1), chart()]
    for which in charts if row.suffix != ".png" else charts[:1]:
        first = row.draw(outline(which, depth), True)
        assert first == row.draw(outline(which, depth), True)
        assert len(first) > 100


def test_every_leg_guard_and_target_stands_on_the_picture() -> None:
    drawn = texts(svg(outline(chart())))
    assert sum(text.startswith("transit_") for text in drawn) == 10
    assert sum(text.startswith("travelled \u2265") for text in drawn) == 40
    assert drawn.count("altitude < 1.5 m (95 % sure)") == sum(
        1 for e in chart().edges if e.trigger.endswith("until1") and not e.loops
    )
    assert any(text == "in any leg: battery < 11 V for 10 s" for text in drawn)
    assert drawn.count("2 times \u00b7 2-4") == 1


def test_every_card_and_frame_tells_its_state() -> None:
    """So that a viewer can light the active one."""
    drawn = ET.fromstring(svg(outline(chart())))
    shown = {g.get("data-path") for g in drawn.iter(f"{SVG}g")} - {None}
    assert shown == {
        s.path.partition("/")[2] for s in chart().states if s.path.startswith(f"{AUTONOMOUS}/")
    }


def test_every_assumption_on_the_picture_has_its_own_unit() -> None:
    prepared = prepare("bottom-following", parameters={})
    assumed = {"current": 0.2, "floor": 15.0, "start": 40.0}
    mission = replace(prepared.mission, assume=tuple(sorted(assumed.items())))
    whole = " ".join(texts(svg(outline(replace(prepared.chart, mission=mission)))))
    plain = " ".join(whole.split())
    for words in ("assumed current 0.2 m/s", "assumed floor 15 m", "assumed start 40 m"):
        assert re.search(rf"{words}(?!/)", plain), words


def test_forty_legs_in_ten_groups_stay_readable_on_one_a4_page() -> None:
    root = ET.fromstring(svg(outline(chart())))
    width, height = float(root.get("width", 0)), float(root.get("height", 0))
    scale = min(210 / width, 297 / height)  # mm per px
    smallest = min(float(t.get("font-size", 99)) for t in root.iter(f"{SVG}text"))
    assert smallest * scale * 72 / 25.4 >= 4.8  # points


def test_nothing_of_the_picture_lies_outside_it_and_no_card_overlaps_another() -> None:
    for which in (chart(), chart(3, 4, 2), chart(30, 5, 20), chart(1, 60, 1)):
        root = ET.fromstring(svg(outline(which), safety=True))
        width, height = float(root.get("width", 0)), float(root.get("height", 0))
        shift = next(root.iter(f"{SVG}g")).get("transform", "")
        dx, dy = (float(v) for v in re.findall(r"[-\d.]+", shift))
        cards = []
        for rect in next(root.iter(f"{SVG}g")).iter(f"{SVG}rect"):
            x, y, w, h = (float(rect.get(k, 0)) for k in ("x", "y", "width", "height"))
            assert x + dx >= 0
            assert x + dx + w <= width
            assert y + dy + h <= height
            if rect.get("stroke") == "#7891ad":
                cards.append((x, y, w, h))
        for i, (x, y, w, h) in enumerate(cards):
            for x2, y2, w2, h2 in cards[i + 1 :]:
                assert x + w <= x2 or x2 + w2 <= x or y + h <= y2 or y2 + h2 <= y


def test_a_wrapped_text_keeps_its_characters_and_its_room() -> None:
    style = canvas.WAY
    text = "altitude < 1.5 m and " + "w" * 80 + " or depth > 3 m"
    lines = canvas.wrap(text, style, 120)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert all(canvas.width(line, style) <= 120 for line in lines)


def test_a_collapsed_group_keeps_the_ways_that_leave_it() -> None:
    whole = outline(chart())
    short = outline(chart(), depth=1)
    assert len(short.leaves()) == 21
    group = next(node for node in short.nodes if node.name == "rows_1")
    assert group.lines == ("3 legs",)
    assert group.number == "2-4"
    assert {way.target for way in group.ways} == {"autonomous/transit_2", IMPLICIT_SURFACE}
    assert [way.text for way in group.ways if way.target != IMPLICIT_SURFACE] == [
        "travelled \u2265 202 m"
    ]
    assert whole.label("autonomous/rows_1/turn2") == "4 turn2"


def test_leaving_a_repeated_group_early_is_a_jump_not_the_way_on() -> None:
    node = next(n for n in outline(chart()).walk() if n.path.endswith("rows_1/turn2"))
    onward = next(way for way in node.ways if way.text.startswith("travelled"))
    assert onward.falls
    edges = tuple(e for e in chart().edges if not e.loops or not e.loops[0].again)
    early = chart()
    early = type(early)(early.mission, early.digest, early.states, tuple(
        type(e)(e.trigger, e.source, e.target, e.by, e.guard) for e in edges
    ), early.initial)  # fmt: skip
    node = next(n for n in outline(early).walk() if n.path.endswith("rows_1/turn2"))
    assert not any(way.falls for way in node.ways)


def test_a_picture_without_a_font_is_refused_not_written_empty(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("mission.authoring.graph.raster._render", lambda *_: b"the same")
    fonts.cache_clear()
    with pytest.raises(NoFont, match=r"\.svg"):
        FORMATS[".png"].draw(outline(chart()), False)
    fonts.cache_clear()


def test_mermaid_links_only_states_that_stand_side_by_side() -> None:
    parents: dict[str, str] = {}
    stack: list[str] = [""]
    for line in mermaid(outline(chart(3, 3, 3)), safety=True).splitlines():
        word = line.strip()
        if match := re.match(r"state (?:\".*\" as )?(\w+)( \{)?$", word):
            parents.setdefault(match[1], stack[-1])
            if match[2]:
                stack.append(match[1])
        elif word == "}":
            stack.pop()
        elif match := re.match(r"(\w+) --> (\w+) :", word):
            assert parents[match[1]] == parents[match[2]] == stack[-1]
    assert stack == [""]


@pytest.mark.parametrize("name", ["end", "a-b", "state", "x:y;z", 'q"{}', "--", "note #1"])
def test_awkward_names_are_no_syntax_in_mermaid(name: str) -> None:
    plain = chart(0, 0, 1)
    old = plain.states[0]
    states = (type(old)(f"{AUTONOMOUS}/{name}", AUTONOMOUS, old.leg, old.setpoint), plain.states[1])
    drawn = mermaid(outline(type(plain)(plain.mission, "0" * 64, states, (), states[0].path)))
    title = next(line for line in drawn.splitlines() if line.endswith(" as s1"))
    inside = title.partition('"')[2].rpartition('"')[0]
    assert re.fullmatch(r"(?:[^\":{}<>%@#;]|#\d+;)*", inside)


def test_json_has_every_state_and_edge_of_the_chart() -> None:
    which = chart()
    data = json.loads(FORMATS[".json"].draw(outline(which), False))
    assert [row["path"] for row in data["states"]] == [state.path for state in which.states]
    assert [row["trigger"] for row in data["edges"]] == [edge.trigger for edge in which.edges]
    assert data["initial"] == which.initial


def test_the_page_loads_nothing_and_has_a_row_per_leg() -> None:
    class Reader(HTMLParser):
        loads: list[str] = []  # noqa: RUF012
        rows = 0

        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            Reader.loads += [v for k, v in attrs if k in ("src", "href") and v and v[0] != "#"]
            Reader.rows += tag == "tr"

    text = FORMATS[".html"].draw(outline(chart()), False).decode()
    Reader().feed(text)
    assert Reader.loads == []
    assert "url(" not in text
    assert "@import" not in text
    assert Reader.rows == 42  # a head, forty legs, the implicit one


def test_every_state_of_a_picture_is_one_of_the_machine() -> None:
    which = chart(2, 2, 2)
    machine = Machine(which)
    for node in outline(which).walk():
        machine.restore(node.path)


def test_every_end_of_a_dot_edge_is_a_node_that_is_drawn() -> None:
    for which, depth in ((chart(3, 3, 3), None), (chart(3, 3, 3), 1)):
        drawn = dot(outline(which, depth), safety=True)
        nodes = set(re.findall(r'^\s*"([^"]+)" \[', drawn, re.MULTILINE))
        ends = re.findall(r'^\s*"([^"]+)" -> "([^"]+)" \[', drawn, re.MULTILINE)
        assert len(ends) > 20
        assert {end for pair in ends for end in pair} <= nodes
        clusters = set(re.findall(r'subgraph "([^"]+)"', drawn))
        assert set(re.findall(r'l(?:head|tail)="([^"]+)"', drawn)) <= clusters
        assert any(start == "autonomous/*" for start, _ in ends)


@pytest.mark.parametrize("name", ["first-dive", "transect", "shakedown"])
def test_a_way_that_falls_through_to_the_next_leg_ends_in_no_open_sentence(name: str) -> None:
    drawn = svg(outline(prepare(name).chart))
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", drawn)
    assert any(text.startswith("timeout") and text.endswith("refused or blind") for text in texts)
    ways = [way for node in outline(prepare(name).chart).walk() for way in node.ways]
    assert not [way for way in ways if way.falls and way.text.endswith("or else")]
