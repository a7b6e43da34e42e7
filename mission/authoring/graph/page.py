"""The state graph as one HTML page: the picture, and a table of all legs. It loads nothing."""

from __future__ import annotations

from html import escape

from mission.authoring.graph.outline import Node, Outline, Way
from mission.authoring.graph.svg import svg
from mission.model import AUTONOMOUS

_STYLE = """
:root { color-scheme: light; }
body { font: 14px/1.45 system-ui, "Segoe UI", Roboto, Helvetica, Arial, sans-serif;
  color: #10243e; margin: 0 auto; max-width: 1400px; padding: 1rem 1.5rem 3rem; }
figure { margin: 0; overflow-x: auto; } figure svg { max-width: 100%; height: auto; }
h2 { font-size: 1.05rem; margin: 2rem 0 .5rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .35rem .7rem;
  border-bottom: 1px solid #dbe3ec; }
th { position: sticky; top: 0; background: #eef4fb; }
tbody tr:hover, tbody tr:target { background: #f4f8fd; }
td:first-child { color: #64748b; font-variant-numeric: tabular-nums; }
.group { color: #64748b; } .ways { margin: 0; padding: 0; list-style: none; }
.timeout, .else { color: #b45309; } .on, .uncertain { color: #b91c1c; }
a { color: #1d4f8f; text-decoration: none; } a:hover { text-decoration: underline; }
@media print { th { position: static; } figure { page-break-after: always; } }
"""


def page(outline: Outline, safety: bool = False) -> str:
    title = escape(f"Mission {outline.chart.mission.name}")
    rows = "\n".join(_row(outline, node) for node in outline.leaves())
    handlers = "".join(_way(outline, way) for way in outline.handlers)
    for node in outline.walk():
        if node.children and node.ways:
            inner = "".join(_way(outline, way) for way in node.ways)
            handlers += (
                f'<li><span class="group">{escape(_place(node))}</span><ul>{inner}</ul></li>'
            )
    always = f"<h2>In any leg</h2><ul>{handlers}</ul>" if handlers else ""
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title><style>{_STYLE}</style></head>
<body><figure>{svg(outline, safety)}</figure>
{always}
<h2>Legs</h2>
<table><thead><tr><th>#</th><th>Leg</th><th>What it holds and does</th><th>Ways out, as tried</th>
</tr></thead><tbody>
{rows}
</tbody></table></body></html>
"""


def _row(outline: Outline, node: Node) -> str:
    around = _place(node).rpartition("/")[0]
    group = f'<span class="group">{escape(around)}/</span>' if around else ""
    lines = "<br>".join(escape(line) for line in node.lines)
    ways = "".join(_way(outline, way) for way in node.ways)
    return (
        f'<tr id="leg{node.number}"><td>{node.number}</td><td>{group}{escape(node.name)}</td>'
        f'<td>{lines}</td><td><ul class="ways">{ways}</ul></td></tr>'
    )


def _way(outline: Outline, way: Way) -> str:
    target = next((n for n in outline.walk() if n.path == way.target), None)
    name = escape(outline.label(way.target))
    if target is not None:
        name = f'<a href="#leg{target.number}">{name}</a>'
    again = " (once all rounds are flown)" if way.again else ""
    return f'<li class="{way.by.value}">{escape(way.text)} &rarr; {name}{again}</li>'


def _place(node: Node) -> str:
    return node.path.removeprefix(f"{AUTONOMOUS}/")
