"""The page: pictures and figures of each recording, and the story. It asks no other host."""

from __future__ import annotations

import html
from collections.abc import Sequence

from mission.analysis.report.dive import Dive
from mission.analysis.report.figures import pictures
from mission.analysis.story import story
from mission.analysis.tell import html_body, page, printable
from mission.model import Record
from mission.onboard.blackbox import Gap


def report_page(
    title: str, recordings: Sequence[Sequence[Record | Gap]], dives: Sequence[tuple[Dive, str]]
) -> str:
    """``dives``: each with its figures in words."""
    parts = []
    for number, (dive, figures) in enumerate(dives, 1):
        heading = f"Dive {number} of {len(dives)}" if len(dives) > 1 else "The dive"
        parts.append(f"<h2>{heading}: {_escaped(dive.vehicle.name)}</h2>")
        parts.append(f"<pre>{html.escape(figures)}</pre>")
        for caption, svg in pictures(dive):
            shown = f"<figcaption>{_escaped(caption)}</figcaption>"
            parts.append(f"<figure>{svg}{shown}</figure>")
    return page(title, "\n".join([*parts, html_body(story(recordings))]))


def _escaped(text: str) -> str:
    return html.escape(printable(text))
