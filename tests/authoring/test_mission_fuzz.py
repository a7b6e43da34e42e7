"""Missions are data: whatever a text says, it is a mission or a complaint, and runs no Python."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import mission
from mission.authoring.check import check_mission
from mission.authoring.check.flow import ROUNDS
from mission.authoring.compiler.compiler import compile_mission
from mission.authoring.language import MissionErrors, digest, parse, parse_script, script
from mission.model.shipped import load_vehicle, missions_folder

AUV = load_vehicle("auv")
SHIPPED = [
    path.read_text(encoding="utf-8")
    for path in sorted(missions_folder().iterdir())
    if path.suffix in (".yaml", ".mission")
]
NASTY = [
    "__import__('os').system('true')", "eval('1')", "exec('x=1')", "().__class__.__mro__",
    "!!python/object/apply:os.system ['true']", "!!python/name:os.system", "{{7*7}}", "${HOME}",
    "getattr(depth, 'x')", "depth.__class__", "depth if 1 else 2", "lambda: 1", "`true`", "\0",
    "*anchor", "&a [*a, *a]", "<<: {a: 1}", "1e999", "-1e-999", "nan", "inf", "9" * 400, "\u202e",
    "٣", "until", "->", "repeat 999999:", "end", "group a:", "on depth > 1 -> up", "(" * 300,
    "not " * 300, "and", "sure 95%", "held 1", "@", "$", "ZAX0", "ZAV9", "\r", "\t", "\ufeff",
]  # fmt: skip
_WATCHED = {"exec", "compile", "import", "open", "os.system", "subprocess.Popen", "socket.connect"}
_events: list[str] = []
_watching = [False]


_VEHICLES = missions_folder() / "vehicles"


def _reads_a_shipped_vehicle(event: str, arguments: tuple[object, ...]) -> bool:
    """A guard's unknown name is looked up there: data, and never a path that the text gives."""
    if event != "open" or arguments[1] not in ("r", None):
        return False
    return Path(str(arguments[0])).parent == _VEHICLES


def _audit(event: str, arguments: tuple[object, ...]) -> None:
    if _watching[0] and event in _WATCHED and not _reads_a_shipped_vehicle(event, arguments):
        _events.append(f"{event} {arguments[:1]!r}")


sys.addaudithook(_audit)


@contextmanager
def nothing_runs() -> Iterator[None]:
    _events.clear()
    _watching[0] = True
    try:
        yield
    finally:
        _watching[0] = False
    assert _events == []


def judged(text: str) -> str:
    """What becomes of it; every other exception than the rooms' own is a failure."""
    try:
        read = parse(text)
        chart = compile_mission(read, AUV, digest(read))
    except MissionErrors:
        return "complaint"
    report = check_mission(chart, AUV)
    assert parse_script(script(read)) is not None
    return "accepted" if report.ok else "refused"


@pytest.fixture(scope="module", autouse=True)
def _loaded() -> None:
    """Imports happen at first use, and are not what is watched."""
    for text in (*SHIPPED, *NASTY, *(shipped + "\n- x\n" for shipped in SHIPPED)):
        judged(text)


@pytest.mark.parametrize("text", SHIPPED)
def test_a_shipped_mission_reaches_no_python(text: str) -> None:
    with nothing_runs():
        assert judged(text) == "accepted"


def test_the_watch_itself_sees_python() -> None:
    with pytest.raises(AssertionError), nothing_runs():
        eval("1")


@st.composite
def spoilt(draw: st.DrawFn) -> str:
    """A shipped mission with some of its text replaced, doubled, dropped or made nasty."""
    text = draw(st.sampled_from(SHIPPED))
    for _ in range(draw(st.integers(1, 5))):
        lines = text.split("\n")
        row = draw(st.integers(0, len(lines) - 1))
        words = lines[row].split(" ")
        word = draw(st.integers(0, len(words) - 1))
        match draw(st.integers(0, 5)):
            case 0:
                words[word] = draw(st.sampled_from(NASTY))
            case 1:
                words[word] = words[word] + draw(st.sampled_from(NASTY))
            case 2:
                del words[word]
            case 3:
                words[word] = draw(st.text(max_size=8))
            case 4:
                lines.insert(row, lines[draw(st.integers(0, len(lines) - 1))])
            case _:
                words[word:word] = draw(st.sampled_from(lines)).split()
        lines[row] = " ".join(words)
        text = "\n".join(lines)
    return text


@pytest.mark.proof
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(spoilt())
def test_a_spoilt_mission_is_judged_and_runs_nothing(text: str) -> None:
    with nothing_runs():
        judged(text)


@pytest.mark.proof
@settings(max_examples=80, deadline=None)
@given(st.lists(st.text(alphabet=st.characters(min_codepoint=32, max_codepoint=126), max_size=60), max_size=8))  # fmt: skip
@example(["mission a vehicle auv", "x: " + "(" * 190])
def test_lines_of_anything_that_aw_can_carry_are_judged(lines: Sequence[str]) -> None:
    with nothing_runs():
        judged("\n".join(lines))


@pytest.mark.parametrize("nasty", NASTY)
def test_no_place_of_an_expression_reaches_python(nasty: str) -> None:
    for place in (
        "until {} timeout 9", "until depth > {} timeout 9", "for {}", "heading {} for 5s",
        "until depth > 1 held {} timeout 9", "goto {} timeout 60", "repeat {}:",
    ):  # fmt: skip
        with nothing_runs():
            judged(f"mission pool vehicle auv\nstart without fix\na: gear 2 {place.format(nasty)}")
            judged(f"mission {nasty} vehicle {nasty}\na: for 5s")


@pytest.mark.proof
def test_rounds_in_rounds_are_judged_by_a_bounded_walk() -> None:
    """The judging stands in the way of X and W while it lasts."""
    lines = ["mission long vehicle auv", "start without fix"]
    lines += [f"repeat 9999 g{i}:" for i in range(5)]
    lines += ["a: gear 2 for 1s"] + ["end"] * 5
    read, vehicle = parse("\n".join(lines)), load_vehicle("auv")
    report = check_mission(compile_mission(read, vehicle, digest(read)), vehicle)
    assert [r.code for r in report.refusals] == ["too-long"]
    assert ROUNDS <= 5000  # legs walked, some tenths of a second


@pytest.mark.proof
def test_nothing_that_a_mission_reaches_names_eval_exec_or_an_unsafe_loader() -> None:
    here = Path(mission.__file__).parent
    rooms = [
        path
        for room in ("authoring", "engine", "legs", "model")
        for path in here.glob(f"{room}/**/*.py")
        if path.parent.name not in ("graph", "diff")
    ]
    assert len(rooms) > 60
    forbidden = {
        "eval", "exec", "compile", "__import__", "import_module", "system", "popen",
        "unsafe_load", "full_load", "UnsafeLoader", "FullLoader",
    }  # fmt: skip
    found = []
    for path in rooms:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = node.id if isinstance(node, ast.Name) else getattr(node, "attr", "")
            regex = (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id == "re"
            )
            if name in forbidden and not regex:
                found.append(f"{path.name}: {name}")
    assert found == []
