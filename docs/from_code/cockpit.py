"""Pictures of the cockpit, as `make pictures` has made them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

FOLDER = Path(__file__).resolve().parents[1] / "pictures" / "cockpit"
# view -> the tab that opens it
VIEWS: Mapping[str, str] = MappingProxyType(
    {
        "fly": "Chart",
        "command": "Command",
        "stick": "Stick",
        "checklist": "Checklist",
        "legs": "Legs",
        "plan": "Plan",
        "review": "Chart",
    }
)
# name -> width and height, CSS pixels
SIZES: Mapping[str, tuple[int, int]] = MappingProxyType(
    {"laptop": (1400, 900), "tablet": (1024, 768), "phone": (390, 844)}
)


def file_of(view: str, size: str) -> Path:
    return FOLDER / f"{view}-{size}.png"


def cockpit_pictures(view: str) -> str:
    """Markdown. Raises KeyError for a view that there is not."""
    _ = VIEWS[view]
    rows = (
        f"![{view}, {size}, {width} × {height}](/pictures/cockpit/{file_of(view, size).name})"
        for size, (width, height) in SIZES.items()
    )
    return "\n\n".join(rows)
