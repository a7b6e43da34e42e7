"""Laws of damaged black boxes: all that is whole is read, and what is missing is told."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from pathlib import Path
from random import Random
from shutil import copyfile

import pytest

from mission.authoring.prepare import prepare
from mission.model import Record
from mission.model.shipped import missions_folder
from mission.onboard.blackbox import BlackBox, BlackBoxError, Gap, close_part, recording
from mission.onboard.blackbox.form import MAGIC
from mission.onboard.blackbox.scan import Found, Scan, is_first_form
from mission.verification.simulation.flight import fly

FIRST_FORM = Path(__file__).parents[1] / "analysis" / "recorded" / "short-time.mcap"
FORMS = ("growing", "closed", "first form")
Span = tuple[int, int, Record]


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The same short flight in a file that nobody closed and in one that was, and an old one."""
    folder = tmp_path_factory.mktemp("boxes")
    paths = {form: folder / f"{form.replace(' ', '-')}.mcap" for form in FORMS}
    prepared = prepare(missions_folder() / "first-dive.yaml")
    box = BlackBox(paths["growing"])
    fly(prepared.mission, prepared.vehicle, seed=5, recorder=box)
    box.close()
    copyfile(paths["growing"], paths["closed"])
    assert close_part(paths["closed"])
    copyfile(FIRST_FORM, paths["first form"])
    return paths


def spans(data: bytes) -> list[Span]:
    """Each record with the bytes of what it stands in: itself, or its chunk."""
    scan = Scan(is_first_form(data))
    scan.at = len(MAGIC)
    found = [one for one in scan.read(data) if isinstance(one, Found)]
    ends = [*(one.at for one in found[1:]), len(data)]
    last = {one.at: end for one, end in zip(found, ends, strict=True)}
    return [(one.at, last[one.at], one.record) for one in found]


def flip(rng: Random, data: bytearray, many: int) -> list[tuple[int, int]]:
    places = [rng.randrange(len(data)) for _ in range(many)]
    for place in places:
        data[place] ^= rng.randrange(1, 256)
    return [(place, place + 1) for place in places]


def burst(rng: Random, data: bytearray, many: int) -> list[tuple[int, int]]:
    """Flipped bytes that stand together."""
    at = rng.randrange(len(data) - many)
    for place in range(at, at + many):
        data[place] ^= rng.randrange(1, 256)
    return [(at, at + many)]


def hole(rng: Random, data: bytearray, _: int) -> list[tuple[int, int]]:
    at = rng.randrange(len(data))
    end = min(len(data), at + rng.randrange(1, 5000))
    data[at:end] = bytes(end - at)
    return [(at, end)]


def taken_out(rng: Random, data: bytearray, _: int) -> list[tuple[int, int]]:
    at = rng.randrange(len(data))
    end = min(len(data), at + rng.randrange(1, 5000))
    del data[at:end]
    return [(at, end)]


def cut(rng: Random, data: bytearray, _: int) -> list[tuple[int, int]]:
    at = rng.randrange(len(MAGIC), len(data))
    end = len(data)
    del data[at:]
    return [(at, end)]


DAMAGE = (
    *((flip, many) for many in (1, 16, 1000)),
    *((burst, many) for many in (1, 16, 1000)),
    (hole, 0),
    (taken_out, 0),
    (cut, 0),
)


def try_one(path: Path, whole: bytes, known: list[Span], number: int, form: str) -> None:
    rng = Random(f"{form} {number}")
    data = bytearray(whole)
    harm, many = DAMAGE[number % len(DAMAGE)]
    harmed = harm(rng, data, many)
    path.write_bytes(data)
    try:
        items = list(recording(path))
    except BlackBoxError:  # neither its first bytes nor any record
        items = []
        assert data[: len(MAGIC)] != MAGIC
    read = [item for item in items if isinstance(item, Record)]
    gaps = [item for item in items if isinstance(item, Gap)]

    remaining = iter(known)
    for record in read:  # nothing else is read, and in its order
        assert any(record == one for _, _, one in remaining), (form, number, record)
    starts, ends = [a for a, _ in sorted(harmed)], [b for _, b in sorted(harmed)]
    touched = [bisect_left(starts, end) > bisect_right(ends, at) for at, end, _ in known]
    there = set(read)
    lost = [
        one for (_, _, one), hit in zip(known, touched, strict=True) if not hit and one not in there
    ]
    # what was taken out leaves no trace but the next numbers; the last one has none behind it
    most = 1 if harm is taken_out and form == "growing" else 0
    assert len(lost) <= most, (form, number, harm.__name__, lost[:3])
    missing = len(known) - len(read)
    if missing and items:
        assert any(not gap.whole for gap in gaps) or harm is cut, (form, number)
    if items and all(gap.records is not None for gap in gaps):
        assert sum(gap.records or 0 for gap in gaps) == missing, (form, number)


def try_many(boxes: dict[str, Path], tmp_path: Path, form: str, times: int) -> None:
    whole = boxes[form].read_bytes()
    known = spans(whole)
    assert len(known) > 250
    for number in range(times):
        try_one(tmp_path / "damaged.mcap", whole, known, number, form)


@pytest.mark.proof
@pytest.mark.parametrize("form", FORMS)
def test_whatever_bytes_are_damaged_all_that_is_whole_is_read_and_the_rest_is_told(
    boxes: dict[str, Path], tmp_path: Path, form: str
) -> None:
    try_many(boxes, tmp_path, form, 36)


def test_a_chunk_whose_length_is_wrong_costs_no_chunk_behind_it(
    boxes: dict[str, Path], tmp_path: Path
) -> None:
    """The compressed records end where they end, whatever length is said around them."""
    whole = boxes["closed"].read_bytes()
    known = spans(whole)
    chunks = sorted({at for at, _, _ in known})
    hit = chunks[2]
    data = bytearray(whole)
    length = int.from_bytes(data[hit + 1 : hit + 9], "little")
    data[hit + 1 : hit + 9] = (length + chunks[5] - chunks[3]).to_bytes(8, "little")
    path = tmp_path / "longer.mcap"
    path.write_bytes(data)
    read = [item for item in recording(path) if isinstance(item, Record)]
    assert read == [record for at, _, record in known if at != hit]


@pytest.mark.proof
@pytest.mark.minutes
@pytest.mark.parametrize("form", FORMS)
def test_so_it_is_ten_thousand_times(boxes: dict[str, Path], tmp_path: Path, form: str) -> None:
    try_many(boxes, tmp_path, form, 3334)


def test_a_part_that_is_missing_is_told_by_the_number_of_its_records(tmp_path: Path) -> None:
    path = tmp_path / "box.mcap"
    box = BlackBox(path, limit=60_000)
    records = [
        Record(0.0, "start", b"{}"),
        *(Record(float(n), "rx", bytes(1000)) for n in range(150)),
    ]
    for record in records:
        box.record(record)
        box.store(box.take())
    box.close()
    part = tmp_path / "box.part2.mcap"
    inside = [r for r in spans(part.read_bytes()) if r[2].kind == "rx"]
    part.unlink()
    items = list(recording(path))
    (gap,) = [item for item in items if isinstance(item, Gap)]
    assert gap.records == len(inside)
    assert (gap.after, gap.before) == (inside[0][2].t - 1.0, inside[-1][2].t + 1.0)
    path.unlink()
    items = list(recording(tmp_path / "box.part3.mcap"))
    assert isinstance(items[0], Record)
    assert isinstance(items[1], Gap)
    assert items[1].records == round(items[1].before or 0.0)
