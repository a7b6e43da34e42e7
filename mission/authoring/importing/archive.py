"""Read one member of a ZIP file, with a limit, since a small file may unpack to gigabytes."""

from __future__ import annotations

import io
import zipfile
import zlib

from mission.authoring.importing.route import Findings
from mission.model.extent import BYTES

_MEMBERS = 1000


def is_archive(data: bytes) -> bool:
    return data.startswith(b"PK\x03\x04")


def member(data: bytes, suffix: str, first: str, found: Findings) -> bytes:
    """The bytes of the member named ``first``, or else of the only one with the suffix. Raises
    ImportErrors."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            name = _chosen(archive.namelist(), suffix, first, found)
            with archive.open(name) as file:
                content = file.read(BYTES.most + 1)
    except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError) as error:
        raise found.refusal("plan-format", "", f"cannot be unpacked: {error}") from None
    if len(content) > BYTES.most:
        raise found.refusal("too-long", name, f"it has {BYTES.exceeded}, which no plan has")
    found.read_in(content)
    return content


def _chosen(names: list[str], suffix: str, first: str, found: Findings) -> str:
    fits = [name for name in names[:_MEMBERS] if name.lower().endswith(suffix)]
    for name in fits:
        if name.rpartition("/")[2].lower() == first:
            return name
    if len(fits) != 1:
        raise found.refusal("plan-format", "", f"it holds {len(fits)} files *{suffix}, not one")
    return fits[0]
