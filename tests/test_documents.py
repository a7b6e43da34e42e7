"""README and docs say what there is: links resolve, files exist, commands and options run."""

from __future__ import annotations

import configparser
import dataclasses
import pkgutil
import re
import tomllib
from pathlib import Path

import click
import pytest

from links import LINKS
from mission.cli import COMMANDS, main
from mission.console.log import BEFORE, FILE
from mission.onboard.configuration import LinkUrls
from mission.onboard.kept import WORKING
from protocol.errata import ERRATA

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
CODE = [p for room in ("mission", "links", "protocol") for p in sorted((ROOT / room).rglob("*.py"))]
RULES = set(re.findall(r"\*\*([RG]\d+)", (ROOT / "docs" / "rules.md").read_text("utf-8")))
KEYS = {f"links.{field.name}" for field in dataclasses.fields(LinkUrls)}  # of serve.yaml

by_name = pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))


def written(text: str) -> set[str]:
    """Files that a guide has its reader write."""
    return set(re.findall(r"(?:^:caption:| >) (\S+)$", text, re.MULTILINE))


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
        assert (ROOT / name).exists() or name in written(text), name


@by_name
def test_a_module_that_is_named_can_be_imported(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    pattern = r"`((?:mission|links|protocol)(?:\.[a-z_0-9]+)+)`|^\.\. auto\w+:: (\S+)$"
    for named in re.findall(pattern, text, re.MULTILINE):
        name = named[0] or named[1]
        if name in KEYS:
            continue
        assert pkgutil.resolve_name(name) is not None, name


@by_name
def test_a_rule_or_reading_that_a_page_cites_is_defined(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    errata = {row.name for row in ERRATA}
    for rule in re.findall(r"\bR\d{1,2}\b(?! *mm)", text):
        assert rule in RULES, rule
    for reading in re.findall(r"\bE-[A-Z]\d+\b", text):
        assert reading in errata, reading


def test_what_is_told_of_the_cockpit_has_the_words_of_its_page() -> None:
    text = (ROOT / "docs" / "operation.md").read_text(encoding="utf-8")
    told = text.partition("### The cockpit")[2].partition("\n### ")[0]
    words = (ROOT / "mission" / "console" / "page" / "words.js").read_text(encoding="utf-8")
    buttons = re.findall(r"(?<!\*)\*([^*\n]+)\*(?!\*)", told)
    assert buttons
    assert [word for word in buttons if f"['{word}'," not in words] == []


def test_a_version_has_each_kind_of_change_once() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    for version in text.split("\n## ")[1:]:
        kinds = re.findall(r"^### (.+)$", version, re.MULTILINE)
        assert len(kinds) == len(set(kinds)), kinds


@by_name
def test_a_page_installs_from_the_project_what_the_project_has(page: Path) -> None:
    """By its bare name an index would be asked, which has it not, or another's."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for what in re.findall(r"pip install (?:-\S+ )*'?([^\s'`]+)", page.read_text(encoding="utf-8")):
        assert what.startswith("."), what
        extra = re.fullmatch(r"\.\[(\w+)\]", what)
        assert not extra or extra[1] in extras["optional-dependencies"], what


def test_every_key_of_a_shipped_vehicle_file_is_explained() -> None:
    page = (ROOT / "docs" / "reference" / "vehicle-file.md").read_text(encoding="utf-8")
    auv = (ROOT / "missions" / "vehicles" / "auv.yaml").read_text(encoding="utf-8")  # shown in it
    said = set(re.findall(r"^(\w+):", auv, re.MULTILINE)) | set(re.findall(r"`(\w+)`", page))
    for path in sorted((ROOT / "missions" / "vehicles").glob("*.yaml")):
        keys = set(re.findall(r"^(\w+):", path.read_text(encoding="utf-8"), re.MULTILINE))
        assert keys <= said, f"{path.name}: {keys - said}"


def test_every_option_of_a_link_is_explained() -> None:
    page = (ROOT / "docs" / "reference" / "configuration.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[^|]+) \|", page.partition("## Links")[2], re.MULTILINE)
    explained = set(re.findall(r"`(\w+)`", " ".join(rows)))
    assert explained == {name for row in LINKS.values() for name in row.options}


def test_the_page_of_files_says_where_each_is() -> None:
    page = (ROOT / "docs" / "reference" / "files.md").read_text(encoding="utf-8")
    on_the_pi, elsewhere = page.split("## Elsewhere")
    assert f"| `{WORKING}` |" in on_the_pi
    assert f"boat/{FILE}` |" in elsewhere
    assert f"`{BEFORE}`" in elsewhere


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
        if name in ("--help", "--version", "COMMAND"):
            continue
        if any(path.endswith(f"/commands/{name}.py") for path in written(text)):
            continue
        assert name in COMMANDS, shown
        command = main.get_command(click.Context(main), name)
        assert command is not None
        known = option_names(command) | {"--help", "-h"}
        for word in (word.strip("[]()`;,") for word in words[1:]):
            if re.fullmatch(r"--?[a-z][a-z-]*", word):
                assert word in known, shown


def test_the_table_of_exit_codes_names_whoever_has_one_of_its_own() -> None:
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| (\d+) \| (.+) \|$", page, re.MULTILINE))
    theirs: dict[str, set[str]] = {}
    for name in COMMANDS:
        command = main.get_command(click.Context(main), name)
        assert command is not None, name
        for code in re.findall(
            r"[,;:] ([3-9]) (?:if|when|where)\b", " ".join((command.help or "").split())
        ):
            theirs.setdefault(code, set()).add(name)
    assert len(theirs) >= 2
    assert {code: set(re.findall(r"`(\w+)`", rows[code])) for code in theirs} == theirs


def test_every_rule_that_code_cites_is_defined() -> None:
    assert len(RULES) == 23
    for path in CODE:
        for rule in re.findall(r"\b([RG]\d{1,2})\b", path.read_text(encoding="utf-8")):
            assert rule in RULES, f"{path.relative_to(ROOT)}: {rule}"


def test_code_cites_no_chapter_by_its_number_and_no_issue() -> None:
    """Numbers of chapters change without a word; a heading or a rule can be looked up."""
    dead = r"\b(?:design|issue) #?\d|\b(?:design|protocols?|rules)(?:\.md)?,? (?:section )?\d|protocols\.md"
    for path in CODE:
        cited = re.search(dead, path.read_text(encoding="utf-8"))
        assert cited is None, f"{path.relative_to(ROOT)}: {cited[0]}"


def test_a_document_that_code_names_is_there() -> None:
    for path in CODE:
        for name in re.findall(r"\bdocs/[\w/-]+\.md\b", path.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{path.relative_to(ROOT)}: {name}"


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
