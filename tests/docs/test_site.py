"""The site is built without a warning, asks no other host for anything, and hangs together."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from blocks import ROOT
from from_code import PARTS
from from_code.layers import rooms
from from_code.way import order_picture

from mission.cli import COMMANDS
from mission.commands.examples import EXAMPLES
from mission.onboard.stream.topics import TOPICS

LOADS = {"link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src"}


class Seen(HTMLParser):
    """What a page loads, where its links lead, and which anchors it has."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.loads: set[str] = set()
        self.links: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if found.get("id"):
            self.anchors.add(str(found["id"]))
        if tag == "a" and found.get("href"):
            self.links.add(str(found["href"]))
        if found.get(LOADS.get(tag, "")) and found.get("rel") not in ("canonical", "next", "prev"):
            self.loads.add(str(found[LOADS[tag]]))


def a_page_loads_nothing_from_another_host(site: Path, pages: dict[Path, Seen]) -> None:
    assert len(pages) > 20
    for page, seen in pages.items():
        foreign = {one for one in seen.loads if re.match(r"(?:[a-z]+:)?//", one)}
        assert not foreign, f"{page.name}: {foreign}"
    for sheet in site.rglob("*.css"):
        loads = re.findall(r"(?:url\(|@import)\s*['\"]?([^'\")\s]+)", sheet.read_text("utf-8"))
        assert not [one for one in loads if "//" in one and not one.startswith("data:")], sheet


def search_works_from_a_folder(site: Path, pages: dict[Path, Seen]) -> None:
    """A page from a folder may load scripts, and may not fetch."""
    search = site / "search.html"
    assert any(one.startswith("searchindex.js") for one in pages[search].loads)
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert index.startswith("Search.setIndex(")
    for word in ("yoyo", "how-to/leg", "reference/glossary"):
        assert word in index, word
    options = (site / "_static" / "documentation_options.js").read_text(encoding="utf-8")
    assert "SHOW_SEARCH_SUMMARY: false" in options


def every_link_leads_to_a_page_and_an_anchor(site: Path, pages: dict[Path, Seen]) -> None:
    for page, seen in pages.items():
        for link in seen.links:
            if re.match(r"[a-z]+:", link):
                continue
            file, _, anchor = link.partition("#")
            there = (page.parent / unquote(file)).resolve() if file else page
            assert there.exists(), f"{page.name}: {link}"
            if anchor and there in pages and there.name != "search.html":
                assert unquote(anchor) in pages[there].anchors, f"{page.name}: {link}"


def every_page_can_be_reached_from_the_first(site: Path, pages: dict[Path, Seen]) -> None:
    def beside(page: Path) -> Iterator[Path]:
        for link in pages[page].links:
            there = (page.parent / link.partition("#")[0]).resolve()
            if there in pages:
                yield there

    found, new = set(), {site / "index.html"}
    while new:
        found |= new
        new = {there for page in new for there in beside(page)} - found
    forms = {site / "genindex.html", site / "search.html"}  # reached by the sidebar
    assert pages.keys() - forms == found - forms


Law = Callable[[Path, dict[Path, Seen]], None]
LAWS: tuple[Law, ...] = (
    a_page_loads_nothing_from_another_host,
    search_works_from_a_folder,
    every_link_leads_to_a_page_and_an_anchor,
    every_page_can_be_reached_from_the_first,
)


@pytest.mark.proof
def test_the_site_is_built_without_a_warning_and_every_law_of_it_holds(tmp_path: Path) -> None:
    """One test, because the site is built once for all of them."""
    site = tmp_path / "site"
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    built = subprocess.run(
        [*command, "-d", str(tmp_path / "trees"), str(ROOT / "docs"), str(site)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    pages = {path: Seen(path) for path in sorted(site.rglob("*.html"))}
    for law in LAWS:
        law(site, pages)


FAULTS = {
    a_page_loads_nothing_from_another_host: '<link href="https://fonts.example/face.css">',
    search_works_from_a_folder: "",
    every_link_leads_to_a_page_and_an_anchor: '<a href="#nowhere">there</a>',
    every_page_can_be_reached_from_the_first: "",
}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.__name__)
def test_a_site_that_breaks_a_law_is_noticed(law: Law, tmp_path: Path) -> None:
    for number in range(25):
        (tmp_path / f"page{number}.html").write_text(FAULTS[law], encoding="utf-8")
    (tmp_path / "index.html").write_text("<p>", encoding="utf-8")
    (tmp_path / "search.html").write_text("<p>", encoding="utf-8")
    with pytest.raises(AssertionError):
        law(tmp_path, {path: Seen(path) for path in sorted(tmp_path.glob("*.html"))})


def test_every_command_has_a_section_with_an_example() -> None:
    text = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    sections = dict(re.findall(r"^### (\S+)\n(.*?)(?=^##|\Z)", text, re.MULTILINE | re.DOTALL))
    assert sections.keys() == COMMANDS.keys()
    for name, section in sections.items():
        assert f"```{{from-code}} command {name}\n" in section, name
        assert re.search(rf"```(?:sh|console)\n(?:.*\n)*?.*auvmission {name}\b", section), name
        assert f"auvmission {EXAMPLES[name]}" in section, name  # which is run, or looked up


def test_every_topic_of_the_black_box_has_its_fields_with_their_meaning() -> None:
    text = PARTS["topics"]("")
    sections = dict(re.findall(r"^### (\w+)\n(.*?)(?=^###|\Z)", text, re.MULTILINE | re.DOTALL))
    assert sections.keys() == TOPICS.keys()
    for name, topic in TOPICS.items():
        assert re.findall(r"^\| `(\w+)` \|", sections[name], re.MULTILINE) == list(
            topic.schema["properties"]
        )


@pytest.mark.proof
def test_the_pictures_show_every_room_and_the_whole_way() -> None:
    picture = PARTS["layers"]("")
    for room in rooms():
        assert re.search(rf"<title>{re.escape(room)}: \w.*\. It uses ", picture), room
    way = order_picture("W")
    steps = [way.index(f">{step}<") for step in ("@ZAWF$", "TopsideCodec.receive", "Engine.step")]
    assert steps == sorted(steps)
    assert steps[-1] < way.index(">AuvCodec.encode<") < way.rindex(">@ZAWF$<")


def test_an_order_or_command_that_does_not_exist_is_an_error_of_the_page() -> None:
    for what, name in (("order", "Q"), ("command", "fly-away")):
        with pytest.raises(LookupError):
            PARTS[what](name)
