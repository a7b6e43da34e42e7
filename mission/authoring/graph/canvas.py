"""Text widths, wrapping, and the few SVG elements of the pictures.

Widths are those of DejaVu Sans, the widest of the fonts that the pictures name, so a text that fits
here fits in all of them. Coordinates are pixels, y downward.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from xml.sax.saxutils import escape, quoteattr

FONTS = "Roboto, Helvetica, Arial, 'DejaVu Sans', sans-serif"

# fmt: off
# Advances of the characters 32..126, hundredths of the size (the font's hmtx table).
_ADVANCE = (
    32, 40, 46, 84, 64, 95, 78, 27, 39, 39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64,
    64, 64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86,
    75, 79, 60, 79, 69, 63, 61, 73, 68, 99, 69, 61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63,
    62, 35, 63, 63, 28, 28, 58, 28, 97, 63, 61, 63, 63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64,
    34, 64, 84,
)
# fmt: on
_OTHER = 100  # any other character
_BOLD = 1.13  # greatest ratio of bold to regular widths


@dataclass(frozen=True, slots=True)
class Style:
    size: float
    colour: str
    bold: bool = False
    anchor: str = "start"


LINE = 13.0  # from one line of small print to the next
NAME = Style(11.0, "#10243e", bold=True)
DETAIL = Style(9.5, "#33475b")
BADGE = Style(8.5, "#10243e", anchor="middle")
WAY = Style(9.0, "#33475b")
TARGET = Style(8.5, "#10243e", bold=True)


def width(text: str, style: Style) -> float:
    text = text.replace("\u00a0", " ")
    total = sum(_ADVANCE[ord(c) - 32] if " " <= c <= "~" else _OTHER for c in text)
    return total * style.size / 100 * (_BOLD if style.bold else 1.0)


def wrap(text: str, style: Style, room: float) -> list[str]:
    """Break text into lines no wider than ``room`` px; a word that is wider is broken, too."""
    lines: list[str] = []
    line = ""
    for word in text.split(" "):
        longer = f"{line} {word}" if line else word
        if width(longer, style) <= room:
            line = longer
            continue
        if line:
            lines.append(line)
        while width(word, style) > room and len(word) > 1:
            cut = next(
                n for n in range(len(word) - 1, 0, -1) if n < 2 or fits(word[:n], style, room)
            )
            lines.append(word[:cut])
            word = word[cut:]
        line = word
    return [*lines, line] if line or not lines else lines


def fits(part: str, style: Style, room: float) -> bool:
    return width(part, style) <= room


def element(name: str, content: str = "", **attributes: object) -> str:
    pairs = "".join(
        f" {key.strip('_').replace('_', '-')}={quoteattr(_value(value))}"
        for key, value in attributes.items()
    )
    return f"<{name}{pairs}>{content}</{name}>" if content else f"<{name}{pairs}/>"


def _value(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def text(x: float, y: float, content: str, style: Style) -> str:
    more: dict[str, object] = {"font_weight": "bold"} if style.bold else {}
    if style.anchor != "start":
        more["text_anchor"] = style.anchor
    return element(
        "text", escape(content), x=x, y=y, font_size=style.size, fill=style.colour, **more
    )


def box(
    x: float,
    y: float,
    w: float,
    h: float,
    fill: str,
    stroke: str,
    radius: float = 4.0,
    **more: object,
) -> str:
    return element(
        "rect", "", x=x, y=y, width=w, height=h, rx=radius, fill=fill, stroke=stroke, **more
    )


def line(points: list[tuple[float, float]], colour: str, weight: float = 1.2) -> str:
    d = "M" + " L".join(f"{x:.6g} {y:.6g}" for x, y in points)
    return element("path", d=d, fill="none", stroke=colour, stroke_width=weight)


def arrow(points: list[tuple[float, float]], colour: str, weight: float = 1.2) -> str:
    """A line with a head at its end; the last segment is horizontal or vertical."""
    (x0, y0), (x1, y1) = points[-2], points[-1]
    length = 6.0
    if x0 == x1:
        step = length if y1 > y0 else -length
        base, head = (x1, y1 - step), f"M{x1:.6g} {y1:.6g} l-3.2 {-step:.6g} h6.4 Z"
    else:
        step = length if x1 > x0 else -length
        base, head = (x1 - step, y1), f"M{x1:.6g} {y1:.6g} l{-step:.6g} -3.2 v6.4 Z"
    return line([*points[:-1], base], colour, weight) + element("path", d=head, fill=colour)


def pill_width(target: str) -> float:
    return width(target, TARGET) + 10


def lead(text: str, target: str, room: float) -> tuple[str, ...]:
    """``text`` in lines of ``room`` px; the last one leaves room for an arrow and the target."""
    lines = wrap(text, WAY, room)
    if target and width(lines[-1], WAY) + 16 + pill_width(target) > room:
        lines.append("")
    return tuple(lines)


def leader(
    lines: tuple[str, ...], target: str, x: float, right: float, y: float, colour: str
) -> str:
    """Draw lines of text; behind the last one an arrow to the right and the target's box."""
    style = replace(WAY, colour=colour)
    parts = [text(x, y + LINE * i, content, style) for i, content in enumerate(lines) if content]
    if target:
        base = y + LINE * (len(lines) - 1)
        wide = pill_width(target)
        start = x + width(lines[-1], WAY) + (4 if lines[-1] else 0)
        parts += [
            arrow([(start, base - 3), (right - wide, base - 3)], colour, 0.9),
            box(right - wide, base - 9, wide, 11.5, "#ffffff", colour, 6, stroke_width=0.8),
            text(right - wide / 2, base - 0.5, target, replace(TARGET, anchor="middle")),
        ]
    return "".join(parts)


def document(w: float, h: float, title: str, body: list[str]) -> str:
    """A whole SVG on a white page."""
    page = element("rect", width=round(w), height=round(h), fill="#ffffff")
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{w:.0f}" height="{h:.0f}" '
        f'viewBox="0 0 {w:.0f} {h:.0f}" font-family={quoteattr(FONTS)} role="img">'
    )
    return "\n".join([head, element("title", escape(title)), page, *body, "</svg>", ""])
