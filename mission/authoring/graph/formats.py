"""The file formats of a state graph: one row per suffix.

``draw`` makes the file's bytes from the outline. Formats for programs contain the whole chart, at
any ``--depth``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from mission.authoring.graph.dot import dot
from mission.authoring.graph.mermaid import mermaid
from mission.authoring.graph.outline import Outline
from mission.authoring.graph.page import page
from mission.authoring.graph.raster import png
from mission.authoring.graph.scxml import scxml
from mission.authoring.graph.svg import svg
from mission.authoring.graph.tables import tables

Draw = Callable[[Outline, bool], bytes]


@dataclass(frozen=True, slots=True)
class Format:
    suffix: str
    what: str
    draw: Draw  # takes the outline, and whether to draw all safety transitions


_ROWS = (
    Format(".svg", "picture, one page", lambda o, s: svg(o, s).encode()),
    Format(".png", "the same as pixels", lambda o, s: png(svg(o, s))),
    Format(".html", "picture and table, one file", lambda o, s: page(o, s).encode()),
    Format(".mmd", "Mermaid stateDiagram-v2", lambda o, s: mermaid(o, s).encode()),
    Format(".dot", "Graphviz", lambda o, s: dot(o, s).encode()),
    Format(".scxml", "W3C SCXML, executable", lambda o, s: scxml(o.chart).encode()),
    Format(".json", "the chart's tables", lambda o, s: tables(o.chart).encode()),
)
FORMATS: Mapping[str, Format] = MappingProxyType({row.suffix: row for row in _ROWS})
