"""Render the SVG as PNG with resvg, and make sure that there is a font.

resvg silently draws no text if it finds no font. So the fonts of Python packages are tried first,
then those of the machine, and a picture without letters is never written.

    NoFont        (the operator must act: install a font, or take the SVG)
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path

_CARRIERS = {  # package -> its folder of fonts; found without importing the package
    "font_roboto": "files",
    "matplotlib": "mpl-data/fonts/ttf",
}
_PROBE = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="20" height="20">'
    '<text x="2" y="16" font-size="16" font-family="Roboto, Helvetica, Arial, '
    "'DejaVu Sans', sans-serif\">{}</text></svg>"
)


class NoFont(LookupError):
    pass


def png(svg: str, zoom: float = 2.0) -> bytes:
    """Render an SVG; ``zoom``: px of the picture for one px of the SVG. Raises NoFont."""
    faces, family = fonts()
    return _render(svg, zoom, faces, family)


@cache
def fonts() -> tuple[tuple[str, ...], str | None]:
    """Folders of fonts, and the family that replaces any other. Raises NoFont."""
    folders = tuple(str(folder) for folder in _folders())
    for family in (None, "Roboto", "DejaVu Sans", "Liberation Sans", "Noto Sans", "Arial"):
        if _render(_PROBE.format("M"), 1.0, folders, family) != _render(
            _PROBE.format(" "), 1.0, folders, family
        ):
            return folders, family
    raise NoFont(
        "no font was found to write the picture's text with: install one "
        "(for instance the package fonts-dejavu-core), or draw .svg instead of .png"
    )


def _folders() -> list[Path]:
    found: list[Path] = []
    for package, inside in _CARRIERS.items():
        spec = importlib.util.find_spec(package)
        for root in (spec.submodule_search_locations or ()) if spec is not None else ():
            folder = Path(root) / inside
            if folder.is_dir():
                found.append(folder)
    return found


def _render(svg: str, zoom: float, folders: tuple[str, ...], family: str | None) -> bytes:
    import resvg_py

    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=svg, zoom=zoom, font_dirs=list(folders), sans_serif_family=family
        )
    )
