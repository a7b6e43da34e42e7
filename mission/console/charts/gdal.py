"""What GDAL reads for us: a layer of a file as GeoJSON geometries, each with its attributes.

It comes with the extra [chart] (pyogrio); nothing else of the program needs it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mission.console.charts.layer import ChartError

EXTRA = "charts of others need an extra: pip install 'auvmission[chart]'"


def features(path: Path, layer: str | None = None, **options: str) -> Iterator[dict[str, Any]]:
    """Of the first layer where none is named; longitude and latitude alone, to 1 cm. ``options``:
    of GDAL's driver. Raises ChartError, also for what is damaged."""
    try:
        from pyogrio import errors, raw
        from shapely.errors import ShapelyError
    except ImportError as error:
        raise ChartError(f"{EXTRA} ({error})") from None
    try:
        meta, _, shapes, columns = raw.read(path, layer, **options)
        flat = [None] * len(columns[0]) if shapes is None else _flat(shapes)
    except (errors.DataSourceError, errors.DataLayerError, ShapelyError, ValueError) as error:
        where = f"{path.name}: {layer}" if layer else path.name
        raise ChartError(f"{where}: {error}") from None
    for n, shape in enumerate(flat):
        said = {name: column[n] for name, column in zip(meta["fields"], columns, strict=True)}
        geometry = None if shape is None else json.loads(shape)
        yield {"type": "Feature", "properties": said, "geometry": geometry}


def _flat(shapes: Any) -> Any:
    """GeoJSON of each."""
    import shapely

    seen = shapely.force_2d(shapely.from_wkb(shapes))
    return shapely.to_geojson(shapely.transform(seen, lambda at: at.round(7)))
