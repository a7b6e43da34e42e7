"""Chapters as text, Markdown or HTML. Texts of vehicles and missions never become markup."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from mission.analysis.chapters import Chapter, Table

_FRAME = re.compile(r"@[A-Z][^\s@$;&]*\$")
_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;margin:.5rem 0}td,th{text-align:left;vertical-align:top;"
    "padding:.15rem .8rem .15rem 0;border-bottom:1px solid #ddd}h2{margin-top:2rem}"
    "figure{margin:1rem 0;overflow-x:auto}pre,table{display:block;overflow-x:auto}"
    "code{white-space:nowrap;font-size:90%}figure svg{max-width:100%;min-width:38rem;height:auto}"
)


def as_text(title: str, chapters: Sequence[Chapter]) -> str:
    parts = [title, "=" * len(title)]
    for chapter in chapters:
        parts += ["", chapter.title, "-" * len(chapter.title), *chapter.says]
        for table in chapter.tables:
            parts += _columns(table)
    return "\n".join(map(printable, parts)) + "\n"


def _columns(table: Table) -> list[str]:
    rows = [table.head, *table.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(table.head))]
    padded = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]
    return ["  ".join(row).rstrip() for row in padded]


def printable(line: str) -> str:
    """Return the text, with all unprintable characters escaped: nothing can control the
    terminal."""
    return line if line.isprintable() else line.encode("unicode_escape").decode()


def as_markdown(title: str, chapters: Sequence[Chapter]) -> str:
    parts = [f"# {_marked(title)}"]
    for chapter in chapters:
        parts += ["", f"## {_marked(chapter.title)}"]
        parts += [line for says in chapter.says for line in ("", _marked(says))]
        for table in chapter.tables:
            rows = [table.head, ("---",) * len(table.head)]
            cells = [*rows, *(tuple(map(_marked, row)) for row in table.rows)]
            parts += ["", *(f"| {' | '.join(row)} |" for row in cells)]
    return "\n".join(parts) + "\n"


def _marked(text: str) -> str:
    return re.sub(r"([\\`*_<>|\[\]{}$#])", r"\\\1", printable(text))


def as_html(title: str, chapters: Sequence[Chapter]) -> str:
    return page(title, html_body(chapters))


def page(title: str, inner: str) -> str:
    """Return a complete HTML page around ``inner``; it loads nothing from any other host."""
    head = f'<meta charset="utf-8"><title>{_escaped(title)}</title><style>{_STYLE}</style>'
    head += '<meta name="viewport" content="width=device-width">'
    body = f"<h1>{_escaped(title)}</h1>\n{inner}"
    return f"<!doctype html>\n<html><head>{head}</head>\n<body>{body}</body></html>\n"


def html_body(chapters: Sequence[Chapter]) -> str:
    parts = []
    for chapter in chapters:
        parts.append(f"<h2>{_escaped(chapter.title)}</h2>")
        parts += [f"<p>{_coded(says)}</p>" for says in chapter.says]
        for table in chapter.tables:
            head = "".join(f"<th>{_escaped(cell)}</th>" for cell in table.head)
            rows = ("".join(f"<td>{_coded(c)}</td>" for c in row) for row in table.rows)
            parts.append(f"<table><tr>{head}</tr>{''.join(f'<tr>{r}</tr>' for r in rows)}</table>")
    return "\n".join(parts)


def _coded(text: str) -> str:
    """Mark frames as code, so that no line breaks inside them."""
    return _FRAME.sub(r"<code>\g<0></code>", _escaped(text))


def _escaped(text: str) -> str:
    return html.escape(printable(text))


FORMS: Mapping[str, Callable[[str, Sequence[Chapter]], str]] = MappingProxyType(
    {"text": as_text, "markdown": as_markdown, "html": as_html}
)
