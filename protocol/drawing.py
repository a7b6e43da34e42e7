"""A frame's layout as boxes of characters, and tables in Markdown.

What does not live here: their contents (protocol.reference).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

WIDTH = 78  # characters of a drawing
OVERHANG = 3  # characters of the offset behind the last box

Cell = tuple[str, str]  # offset ("" if it varies), content


def drawing(cells: Sequence[Cell]) -> Iterator[str]:
    """Draw rows of boxes, the offset of each above its left edge; an empty last cell is the end."""
    end = cells[-1][0] if cells[-1][1] == "" else ""
    boxes = [c for c in cells if c[1]]
    rows: list[list[Cell]] = [[]]
    for cell in boxes:
        width = sum(_box(c) for c in [*rows[-1], cell])
        if rows[-1] and width + OVERHANG > WIDTH:
            rows.append([])
        rows[-1].append(cell)
    for n, row in enumerate(rows):
        after = rows[n + 1][0][0] if n + 1 < len(rows) else end
        above = "".join(at.ljust(_box((at, text))) for at, text in row) + after
        if above.strip():
            yield above.rstrip()
        yield "+" + "".join("-" * (_box(c) - 1) + "+" for c in row)
        yield "|" + "".join(f" {text}".ljust(_box((at, text)) - 1) + "|" for at, text in row)
        yield "+" + "".join("-" * (_box(c) - 1) + "+" for c in row)


def _box(cell: Cell) -> int:
    return max(len(cell[0]) + 1, len(cell[1]) + 3)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    cells = [[text.replace("|", "\\|") for text in row] for row in (head, *rows)]
    widths = [max(len(row[n]) for row in cells) for n in range(len(head))]
    yield _line(cells[0], widths)
    yield "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    for row in cells[1:]:
        yield _line(row, widths)


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = (text.ljust(width) for text, width in zip(cells, widths, strict=True))
    return "| " + " | ".join(padded) + " |"
