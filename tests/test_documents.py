"""README and docs say what there is: links resolve, files exist, commands and options run."""

from __future__ import annotations

import configparser
import re
from pathlib import Path

import click
import pytest

from mission.cli import COMMANDS, main

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
CODE = [p for room in ("mission", "links", "protocol") for p in sorted((ROOT / room).rglob("*.py"))]

by_name = pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)


def anchors(page: Path) -> set[str]:
    """As GitHub makes them of headings."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@by_name
def test_a_link_of_ours_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        there = page.parent / file if file else page
        assert there.exists(), target
        assert not anchor or anchor in anchors(there), target


@by_name
def test_a_file_that_is_named_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in re.findall(
        r"\b(?:mission|missions|links|protocol|tests|docs|deploy)/[\w/.-]*\w", text
    ):
        assert (ROOT / name).exists(), name


def option_names(command: click.Command) -> set[str]:
    return {name for one in command.params for name in (*one.opts, *one.secondary_opts)}


@by_name
def test_a_command_that_is_shown_exists_with_its_options(page: Path) -> None:
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    for shown in re.findall(
        r"^\s*(?:\S*/)?auvmission (.+)$|`auvmission ([^`]+)`", text, re.MULTILINE
    ):
        words = re.split(r"\s+#|\s{2,}[a-z]", shown[0] or shown[1])[0].split()
        name = words[0]
        assert name in COMMANDS, shown
        command = main.get_command(click.Context(main), name)
        assert command is not None
        known = option_names(command) | {"--help", "-h"}
        for word in (word.strip("[]()`;,") for word in words[1:]):
            if re.fullmatch(r"--?[a-z][a-z-]*", word):
                assert word in known, shown


def test_every_rule_that_code_cites_is_defined() -> None:
    defined = set(re.findall(r"\*\*([RG]\d+)", (ROOT / "docs" / "rules.md").read_text("utf-8")))
    assert len(defined) == 22
    for path in CODE:
        for rule in re.findall(r"\b([RG]\d{1,2})\b", path.read_text(encoding="utf-8")):
            assert rule in defined, f"{path.relative_to(ROOT)}: {rule}"


def test_every_command_has_a_line_of_help() -> None:
    for name in COMMANDS:
        command = main.get_command(click.Context(main), name)
        assert command is not None, name
        assert command.get_short_help_str(), name
        for one in command.params:
            assert not isinstance(one, click.Option) or one.help, f"{name} {one.name}"


def test_the_wings_that_the_design_draws_are_those_of_the_contract() -> None:
    contracts = configparser.ConfigParser()
    contracts.read(ROOT / ".importlinter", encoding="utf-8")
    layers = contracts["importlinter:contract:wings"]["layers"].strip()
    drawn = re.findall(
        r"^```\n(.+?)\n```", (ROOT / "docs" / "design.md").read_text("utf-8"), re.M | re.S
    )
    assert layers in drawn
    there = {p.name for p in (ROOT / "mission").iterdir() if (p / "__init__.py").exists()}
    assert there == set(re.findall(r"mission\.(\w+)", layers)) - {"cli"}
