"""The charts of this console: their order, on or off, and opacity; stored for the next time.

    <folder>/charts.json    {name of the file: {"on": bool, "opacity": 0 to 1}, ...} in their order

A failed write stops nothing. Files dropped on the page are kept in a temporary folder until the
console ends.
"""

from __future__ import annotations

import contextlib
import json
import re
import tempfile
from pathlib import Path
from typing import Any

from mission.console.charts.grid import read_grid
from mission.console.charts.layer import ChartError, Layer
from mission.console.charts.picture import PICTURES, is_corners, placed_by, read_picture
from mission.console.charts.shapes import read_shapes
from mission.console.charts.tiles import read_mbtiles, read_pmtiles

FILE = "charts.json"
MOST = 32  # charts
READERS = {
    ".geojson": read_shapes, ".json": read_shapes,
    ".asc": read_grid, ".xyz": read_grid, ".csv": read_grid,
    ".mbtiles": read_mbtiles, ".pmtiles": read_pmtiles,
    **dict.fromkeys(PICTURES, read_picture),
}  # fmt: skip
WORLDS = re.compile(r"\.([a-z]{2,4}w|wld)")


def read_chart(path: Path) -> Layer:
    """Read a chart, by its suffix. Raises ChartError."""
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise ChartError(f"{path.name}: a chart ends in {', '.join(READERS)}")
    try:
        return reader(path)
    except OSError as error:
        raise ChartError(f"{path.name}: {error.strerror or error}") from None
    except ChartError:
        raise
    except (ValueError, TypeError, AttributeError, LookupError, OverflowError) as error:
        raise ChartError(f"{path.name}: no such file as it says it is: {error}") from None


class Shelf:
    def __init__(
        self, folder: Path, paths: tuple[Path, ...] = (), under: Layer | None = None
    ) -> None:
        """``under``: the layer below all others until somebody moves it. Raises ChartError."""
        self._file = folder / FILE
        self._layers: dict[str, Layer] = {}
        self._brought: tempfile.TemporaryDirectory[str] | None = None
        if under is not None:
            self._put(under)
        for path in paths:
            if path.name in self._layers:
                raise ChartError(f"{path}: two charts have this name: rename one")
            self._put(read_chart(path))

    def as_objects(self) -> list[dict[str, Any]]:
        """Return the layers, the lowest first."""
        looks = self._looks()
        known = [name for name in looks if name in self._layers]
        order = [*known, *(name for name in self._layers if name not in known)]
        plain = {"on": True, "opacity": 1.0}
        return [
            {**self._layers[name].as_object(), **plain, **looks.get(name, {})} for name in order
        ]

    def find(self, name: str) -> Layer | None:
        return self._layers.get(name)

    def bring(self, name: str, body: bytes) -> str:
        """Take a file from the page. Return the layer's name; "" for the position of a picture that
        is still to come. Raises ChartError."""
        bare = re.split(r"[/\\]", name)[-1][-100:].lstrip(".")
        suffix = Path(bare).suffix.lower()
        if suffix not in READERS and not WORLDS.fullmatch(suffix):
            raise ChartError(f"{bare}: a chart ends in {', '.join(READERS)}")
        self._brought = self._brought or tempfile.TemporaryDirectory(prefix="auvmission-charts-")
        path = Path(self._brought.name) / bare
        path.write_bytes(body)
        if suffix not in READERS or (suffix == ".json" and is_corners(_json(body))):
            return ""
        if suffix in PICTURES and placed_by(path) is None:
            raise ChartError(f"{bare}: drop it together with its world file or {bare}.json")
        self._put(read_chart(path))
        return bare

    def arrange(self, said: Any) -> None:
        """[{"name", "on", "opacity"}, ...], the lowest first. Raises ChartError."""
        try:
            wanted = {
                str(one["name"]): {"on": bool(one["on"]), "opacity": float(one["opacity"])}
                for one in said
                if one["name"] in self._layers and 0 <= one["opacity"] <= 1
            }
        except (TypeError, KeyError, ValueError):
            raise ChartError("each layer has a name, on, and an opacity from 0 to 1") from None
        others = {name: look for name, look in self._looks().items() if name not in wanted}
        kept = dict([*others.items(), *wanted.items()][-10 * MOST :])
        beside = self._file.with_suffix(".new")
        with contextlib.suppress(OSError):
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside.write_text(json.dumps(kept), encoding="utf-8")
            beside.replace(self._file)

    def close(self) -> None:
        if self._brought is not None:
            self._brought.cleanup()

    def _put(self, layer: Layer) -> None:
        if layer.name not in self._layers and len(self._layers) >= MOST:
            raise ChartError(f"{layer.name}: {MOST} charts are open already")
        self._layers[layer.name] = layer

    def _looks(self) -> dict[str, dict[str, Any]]:
        found = _json(self._file.read_bytes()) if self._file.is_file() else None
        if not isinstance(found, dict):
            return {}
        return {name: look for name, look in found.items() if _is_look(look)}


def _is_look(look: Any) -> bool:
    return (
        isinstance(look, dict)
        and isinstance(look.get("on"), bool)
        and isinstance(look.get("opacity"), int | float)
        and look.keys() == {"on", "opacity"}
    )


def _json(body: bytes) -> Any:
    with contextlib.suppress(ValueError, RecursionError):
        return json.loads(body)
    return None
