"""``auvmission find-crc``: find the CRC that the ``@SD`` frames of a capture use (E-V19)."""

from __future__ import annotations

from typing import TYPE_CHECKING, BinaryIO

import click

if TYPE_CHECKING:
    from collections.abc import Iterator

LENGTH = 86


@click.command(name="find-crc")
@click.option("--json", "as_json", is_flag=True, help="One JSON object.")
@click.option("--hex", "as_hex", is_flag=True, help="The input is hexadecimal text.")
@click.argument("file", type=click.File("rb"))
def find_crc(as_json: bool, as_hex: bool, file: BinaryIO) -> None:
    """Name the CRC profile of the @SD frames in FILE (- is standard input).

    Write the name after sd_crc: in the vehicle file, or use it as --option sd_crc=NAME.
    """
    import json
    from collections import Counter

    from protocol.checksum import SD_PROFILES, find_sd_crc_profile

    candidates = list(_candidates(_contents(file, as_hex)))
    votes = Counter(name for frame in candidates for name in find_sd_crc_profile(frame))
    ranked = [p.name for p in SD_PROFILES if votes[p.name]]
    ranked.sort(key=lambda name: -votes[name])  # stable sort: the normative reading stays first
    best = ranked[0] if ranked else None
    if as_json:
        counts = {name: votes[name] for name in ranked}
        click.echo(json.dumps({"profile": best, "candidates": len(candidates), "votes": counts}))
    elif best is not None:
        click.echo(f"{best}: right in {votes[best]} of {len(candidates)} candidates")
        for name in ranked[1:]:
            click.echo(f"also {name}: right in {votes[name]}")
    if best is None:
        tried = f"tried {len(SD_PROFILES)} profiles on {len(candidates)} candidates"
        raise click.ClickException(f"no profile fits: {tried} (@SD, {LENGTH} bytes, $)")


def _contents(file: BinaryIO, as_hex: bool) -> bytes:
    data = file.read()
    if not as_hex:
        return data
    try:
        return bytes.fromhex(data.decode("ascii"))
    except ValueError as error:
        raise click.UsageError(f"not hexadecimal: {error}") from None


def _candidates(data: bytes) -> Iterator[bytes]:
    at = data.find(b"@SD")
    while at >= 0:
        frame = data[at : at + LENGTH]
        if len(frame) == LENGTH and frame.endswith(b"$"):
            yield frame
        at = data.find(b"@SD", at + 1)
