"""One Diagnostic for every text: its code is in the table, its place and hint are there."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from mission.model.codes import CODES
from mission.model.diagnostics import Diagnosed, Diagnostic, Diagnostics, MissionErrors, Stage
from mission.model.texts import Where

MISSION = Path(__file__).parents[2] / "mission"
SOURCES = [
    *(
        path
        for room in ("model", "legs", "authoring")
        for path in sorted((MISSION / room).rglob("*.py"))
    ),
    MISSION / "onboard" / "configuration.py",
]
MAKERS = {  # calls of the sources that name a code, and as which argument
    "Complaint": 0,
    "Misfit": 0,
    "_refuse": 0,
    "_refused": 0,
    "_says": 1,
    "add": 0,
    "refusal": 0,
    "refused": 0,
    "says": 0,
    "whole": 0,
}


OF_IMPORTS = MAKERS | {"refuse": 0}  # whose name is another thing elsewhere


def codes_named(path: Path) -> Iterator[str]:
    makers = OF_IMPORTS if path.parent.name == "importing" else MAKERS
    tree = ast.parse(path.read_text("utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
            name = node.func.id if isinstance(node.func, ast.Name) else name
            if name in makers and len(node.args) >= (2 if name == "whole" else 3):
                given = node.args[makers[name]]
                if isinstance(given, ast.Constant) and isinstance(given.value, str):
                    yield given.value


@pytest.mark.proof
def test_every_code_that_the_sources_name_is_in_the_table() -> None:
    named = {code for path in SOURCES for code in codes_named(path)}
    assert len(named) > 80
    assert named <= set(CODES), named - set(CODES)


def test_every_code_of_the_table_stands_in_the_sources() -> None:
    texts = "".join(path.read_text("utf-8") for path in SOURCES if path.name != "codes.py")
    assert not [code for code in CODES if f'"{code}"' not in texts]


def test_a_code_is_a_few_plain_words() -> None:
    for code, says in CODES.items():
        assert code == code.lower()
        assert " " not in code
        assert says[0] == says[0].lower() or says.startswith(("ASCII", "YAML"))
        assert len(says) < 90


def test_diagnostics_are_told_by_stage_and_place() -> None:
    found = [
        Diagnostic(Stage.CHECK, "time", Where(1, 1), "late"),
        Diagnostic(Stage.TEXT, "syntax", Where(3, 1), "third"),
        Diagnostic(Stage.TEXT, "syntax", Where(2, 9), "second"),
        Diagnostic(Stage.TEXT, "syntax", Where(2, 1), "first"),
    ]
    assert [d.message for d in Diagnosed(found).diagnostics] == ["first", "second", "third", "late"]


def test_the_same_is_said_once_of_a_place_and_shown_with_its_line() -> None:
    problems = Diagnostics(Stage.TEXT, "one\r\n\ttwo\r\n", "m")
    for _ in range(2):
        problems.add("syntax", Where(2, 2, 3), "no", "write 2")
    with pytest.raises(MissionErrors) as caught:
        problems.complain()
    (found,) = caught.value.diagnostics
    assert (found.offending, found.place) == ("two", "m:2:2")
    assert found.brief == "m:2:2: no; write 2"
    assert found.rendered == "m:2:2: no [syntax]\n    \ttwo\n    \t^^^\n    write 2"
    assert str(caught.value).endswith("m: 1 error")
