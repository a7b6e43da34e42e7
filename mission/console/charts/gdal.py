"""Reading by GDAL: a layer of a file as GeoJSON geometries, each with its attributes.

GDAL comes with the extra [chart] (pyogrio); nothing else in the program needs it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mission.console.charts.layer import ChartError

EXTRA = "charts of others need an extra: pip install 'auvmission[chart]'"


def features(path: Path, layer: str | None = None, **options: str) -> Iterator[dict[str, Any]]:
    """Yield the features of a layer, by default the first; longitude and latitude only, to 1 cm.
    ``options``: of GDAL's driver. Raises ChartError, also for damaged files."""
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
    """Return GeoJSON of each shape."""
    import shapely

    seen = shapely.force_2d(shapely.from_wkb(shapes))
    return shapely.to_geojson(shapely.transform(seen, lambda at: at.round(7)))
