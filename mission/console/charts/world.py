"""The coasts of the world below all else: Natural Earth 1:110 million, in the public domain.

pyogrio includes it for its own tests. Without the extra [chart], or without the file, there is no
outline; the grid stays.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mission.console.charts.gdal import features
from mission.console.charts.layer import ChartError, Layer

NAME = "world"
NOTE = "coasts, some 10 km off: to find one's way, none to navigate by"
OFF_M = 10_000.0
WITHIN = "tests/fixtures/naturalearth_lowres/naturalearth_lowres.shp"  # pyogrio
EDGE = (-179.99, -85.0, 179.99, 84.0)  # countries are cut at the map's edge, where no coast is


def read_world() -> Layer | None:
    """Return the coasts as lines; None if the file is not here."""
    package = find_spec("pyogrio")
    if package is None or package.origin is None:
        return None
    try:
        countries = [one["geometry"] for one in features(Path(package.origin).parent / WITHIN)]
    except ChartError:
        return None
    data = json.dumps(_coasts(countries), separators=(",", ":")).encode()
    return Layer(NAME, "shapes", EDGE, NOTE, data, more={"off_m": OFF_M})


def _coasts(countries: list[Any]) -> list[dict[str, Any]]:
    """Merge the countries, without the borders between them."""
    from shapely import box, line_merge, unary_union
    from shapely.geometry import mapping, shape

    coasts = unary_union([shape(one) for one in countries]).boundary.intersection(box(*EDGE))
    lines = mapping(line_merge(coasts))["coordinates"]
    plain = {"form": "line", "name": "", "depth": None, "deeper": None}
    return [{"at": [line], **plain} for line in lines]
