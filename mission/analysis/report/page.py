"""The page: pictures and figures of each recording, and the story. It loads nothing from other
hosts.
"""

from __future__ import annotations

import html
from collections.abc import Sequence

from mission.analysis.report.dive import Dive
from mission.analysis.report.figures import as_svg, pictures_of
from mission.analysis.report.words import day, headline, source, track_words
from mission.analysis.story import between
from mission.analysis.tell import html_body, page, printable


def report_page(dives: Sequence[Dive]) -> str:
    """Write for each dive its events, its pictures, then the tables of its story."""
    parts = []
    for number, dive in enumerate(dives, 1):
        if number > 1:
            parts.append(html_body([between(dives[number - 2].items, dive.items)]))
        if len(dives) > 1:
            parts.append(f"<h2>{_escaped(_heading(dives, number))}</h2>")
        parts += [f"<p>{_escaped(source(dive))}</p>", *_dive(dive)]
    return page(day(list(dives)), "\n".join(parts))


def _heading(dives: Sequence[Dive], number: int) -> str:
    """Count dives; a recording after a mere restart of the program belongs to the same dive."""
    dive, firsts = dives[number - 1], [one for one in dives if not one.goes_on]
    if dive.goes_on:
        return f"The same dive, after the program began again: {headline(dive)}"
    at = sum(not one.goes_on for one in dives[:number])
    return f"Dive {at} of {len(firsts)}: {headline(dive)}"


def _dive(dive: Dive) -> list[str]:
    happened, *tables = dive.story
    drawn = [
        f"<figure>{as_svg(one)}<figcaption>{_escaped(one.caption)}</figcaption></figure>"
        for one in pictures_of(dive)
    ]
    figures = f"<pre>{html.escape(track_words(dive))}</pre>"
    return [html_body([happened]), *drawn, figures, html_body(tables)]


def _escaped(text: str) -> str:
    return html.escape(printable(text))
