"""Recordings as files for other programs: a folder for each recording, a form for each use.

columns   topics as sheets: columns with units, rows    places    track, fixes and plans
comma     CSV, a file for each topic                    gpx       GPX 1.1
parquet   Parquet, a file for each topic                kml       KML 2.2
                                                        geojson   RFC 7946
A new form is a row of FORMS. What does not live here: what the values are (onboard.stream).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from mission.analysis.export.columns import ExportError
from mission.analysis.export.comma import csv_files
from mission.analysis.export.geojson import geojson
from mission.analysis.export.gpx import gpx
from mission.analysis.export.kml import kml
from mission.analysis.export.parquet import parquet_files
from mission.analysis.export.places import Places, places
from mission.model import Record
from mission.onboard.blackbox import Gap

Files = Iterator[tuple[str, bytes]]
Items = Sequence[Record | Gap]

__all__ = ["FORMS", "ExportError", "Files", "Items", "folders"]


def _of_places(name: str, made: Callable[[Places], bytes]) -> Callable[[Items], Files]:
    def files(items: Items) -> Files:
        yield name, made(places(items))

    return files


FORMS: Mapping[str, Callable[[Items], Files]] = MappingProxyType(
    {
        "csv": csv_files,
        "parquet": parquet_files,
        "gpx": _of_places("track.gpx", gpx),
        "kml": _of_places("track.kml", kml),
        "geojson": _of_places("track.geojson", geojson),
    }
)


def folders(output: Path, logs: Sequence[Path]) -> list[Path]:
    """Return a folder in ``output`` for each log, with its name; equal names are numbered."""
    taken: list[Path] = []
    for log in logs:
        name = log.stem.strip(".") or "log"
        made, number = output / name, 1
        while made in taken:
            number += 1
            made = output / f"{name}-{number}"
        taken.append(made)
    return taken
