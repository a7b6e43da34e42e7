"""docs/quality.md names tests for every rule of the protocol, and they are there."""

from __future__ import annotations

import re
from pathlib import Path

from mission.verification.exhaustive.run import LAWS

ROOT = Path(__file__).parents[2]
RULES = {f"R{number}" for number in range(1, 19)}


def rows() -> dict[str, list[str]]:
    text = (ROOT / "docs" / "quality.md").read_text(encoding="utf-8")
    found = re.findall(r"^\| (R\d+) \|[^|]*\|([^|]*)\|$", text, re.MULTILINE)
    return {rule: re.findall(r"`(\w+)`", tests) for rule, tests in found}


def test_every_rule_has_tests() -> None:
    assert rows().keys() == RULES
    assert all(rows().values())


def test_every_test_that_is_named_is_there() -> None:
    there: set[str] = set()
    for path in (ROOT / "tests").rglob("test_*.py"):
        there |= set(re.findall(r"^def test_(\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))
    named = {name for names in rows().values() for name in names}
    assert named <= there, named - there


def test_the_laws_of_the_exhaustive_proof_name_their_rules() -> None:
    assert "## The states\n" in (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    for law in LAWS.values():
        assert re.match(r"R\d+|design: the states|as built$|E-", law.source), law
    named = {rule for law in LAWS.values() for rule in re.findall(r"R\d+", law.source)}
    assert {"R3", "R4", "R5", "R6", "R7", "R8", "R9", "R10", "R11", "R12", "R13"} <= named
