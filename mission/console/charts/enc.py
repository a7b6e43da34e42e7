"""Electronic charts of S-57 as GeoJSON that ``--chart`` shows: coasts, land, depths and dangers.

GDAL reads them (the extra [chart]), with the updates (.001, .002, ...) in the same folder as the
cell. Depths are below the chart's own datum; the tide adds to them.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mission.console.charts.gdal import features
from mission.console.charts.layer import ChartError

# object classes of S-57, the lowest first: later ones are drawn above
CLASSES = {
    "LNDARE": "land", "DEPARE": "depth area", "DRGARE": "dredged area", "DEPCNT": "depth contour",
    "SLCONS": "built shore", "COALNE": "coast", "SOUNDG": "sounding", "OBSTRN": "obstruction",
    "WRECKS": "wreck", "UWTROC": "rock",
}  # fmt: skip
DANGERS = ("OBSTRN", "WRECKS", "UWTROC")
DEPTHS = ("DRVAL1", "DRVAL2", "VALDCO", "VALSOU", "DEPTH")
# values of SDAT of S-57, from 1
DATUMS = (
    "mean low water springs", "mean lower low water springs", "mean sea level", "lowest low water",
    "mean low water", "lowest low water springs", "approximate mean low water springs",
    "Indian spring low water", "low water springs", "approximate lowest astronomical tide",
    "nearly lowest low water", "mean lower low water", "low water", "approximate mean low water",
    "approximate mean lower low water", "mean high water", "mean high water springs", "high water",
    "approximate mean sea level", "high water springs", "mean higher high water",
    "equinoctial spring low water", "lowest astronomical tide", "local datum",
    "International Great Lakes Datum 1985", "mean water level", "lower low water large tide",
    "higher high water large tide", "nearly highest high water", "highest astronomical tide",
)  # fmt: skip
WGS84, METRES = 2, 1  # HDAT, DUNI
SPLIT = {"SPLIT_MULTIPOINT": "ON", "ADD_SOUNDG_DEPTH": "ON"}


@dataclass(frozen=True, slots=True)
class Converted:
    """``counts``: of each kind, in words. ``scale``: 1 : scale. ``doubts``: what GDAL could not
    read and skipped."""

    geojson: dict[str, Any]
    counts: Counter[str]
    scale: int
    datum: str
    doubts: tuple[str, ...] = ()


def convert(cell: Path) -> Converted:
    """Convert a cell. Raises ChartError, also if its positions are not in WGS 84 or its depths not
    in m."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always", RuntimeWarning)
        about = _about(cell)
        found = list(_found(cell))
    if not found:
        raise ChartError(f"{cell.name}: none of {', '.join(CLASSES)} is in it")
    counts = Counter(CLASSES[one["properties"]["class"]] for one in found)
    number = int(about["DSPM_SDAT"])
    datum = DATUMS[number - 1] if 1 <= number <= len(DATUMS) else f"a datum of number {number}"
    geojson = {"type": "FeatureCollection", "features": found}
    doubts = tuple(dict.fromkeys(str(one.message) for one in seen))
    return Converted(geojson, counts, int(about["DSPM_CSCL"]), datum, doubts)


def _about(cell: Path) -> dict[str, Any]:
    """Return the cell's identification record (DSID), with depths and heights in m. Raises
    ChartError."""
    first = next(features(cell, "DSID"), None)
    if first is None:
        raise ChartError(f"{cell.name}: its first record is cut short: fetch the cell again")
    about: dict[str, Any] = first["properties"]
    for key, wanted, says in (
        ("DSPM_HDAT", WGS84, "places are not in WGS 84"),
        ("DSPM_DUNI", METRES, "depths are not in metres"),
    ):
        if about[key] != wanted:
            raise ChartError(f"{cell.name}: {key} is {about[key]}, not {wanted}: {says}")
    return about


def _found(cell: Path) -> Iterator[dict[str, Any]]:
    from pyogrio import list_layers

    has = {str(name) for name, _ in list_layers(cell)}
    for name in CLASSES:
        for one in features(cell, name, **SPLIT) if name in has else ():
            if one["geometry"] is not None:
                yield {**one, "properties": _said(name, one["properties"])}


def _said(name: str, said: dict[str, Any]) -> dict[str, Any]:
    """Rename the attributes to the names that charts of shapes use (shapes.py)."""
    own = said.get("OBJNAM")
    label = own if isinstance(own, str) and own else CLASSES[name] if name in DANGERS else ""
    depths = {key: float(said[key]) for key in DEPTHS if _is_given(said.get(key))}
    return {"class": name, "OBJNAM": label, **depths}


def _is_given(value: Any) -> bool:
    return value is not None and value == value  # NaN is no value
