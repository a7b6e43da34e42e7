"""The registry's contract: a new row is tested by being there."""

from __future__ import annotations

import pytest

from protocol.fields import FrameType
from protocol.framing import LinkRow
from protocol.messages import FrameFault
from protocol.tolerances import TOLERANCES, Tolerances, UnknownTolerance
from protocol.vehicles import (
    VEHICLES,
    UnknownDialect,
    UnknownVehicle,
    VehicleRow,
    codec,
    frame_types,
    link,
    links,
    vehicle_row,
)

NAMES = {
    "auv.any",
    "auv.from_stm32",
    "auv.modem",
    "auv.to_pi",
    "auv.to_stm32",
    "auv.to_topside",
}


def test_links_and_types_have_the_names_of_the_document() -> None:
    assert {row.name for row in links()} >= NAMES
    assert len({row.name for row in links()}) == len(links())
    for name, frame in frame_types().items():
        assert name == frame.name
        assert name.partition(".")[0] in {row.name for row in VEHICLES.values()}


@pytest.mark.parametrize("row", links(), ids=lambda r: r.name)
@pytest.mark.parametrize("tolerance", TOLERANCES, ids=lambda t: t.name)
def test_every_link_takes_every_value_of_every_tolerance(row: LinkRow, tolerance: object) -> None:
    from protocol.tolerances import Tolerance

    assert isinstance(tolerance, Tolerance)
    for value in tolerance.values[:4] or ("0x1",):
        framer = row.framer(Tolerances.parse({tolerance.name: value}))
        assert framer.receive(b"\x00", 0.0) == []
        assert framer.flush(1e9) == [FrameFault(0, "bad_header", 1)] or row.line is not None


@pytest.mark.parametrize("row", links(), ids=lambda r: r.name)
def test_every_type_names_its_table(row: LinkRow) -> None:
    for frame in row.frames(Tolerances()):
        assert isinstance(frame, FrameType)
        assert frame.title
        assert frame.lead
        assert frame.length >= 0


def test_an_unknown_name_says_which_there_are() -> None:
    with pytest.raises(UnknownVehicle, match="auv"):
        codec("submarine", "as-built", {})
    with pytest.raises(UnknownVehicle, match=r"auv\.any"):
        link("auv.nowhere")
    with pytest.raises(UnknownTolerance):
        codec("auv", "as-built", {"nothing": "on"})


@pytest.mark.parametrize("row", list(VEHICLES.values()), ids=lambda row: row.name)
def test_a_dialect_nobody_speaks_is_refused_with_those_there_are(row: VehicleRow) -> None:
    with pytest.raises(UnknownDialect, match=f"no dialect 'klingon'.*{row.dialects[0]}"):
        codec(row.name, "klingon", {})


def test_every_vehicle_has_its_steps_and_no_other() -> None:
    for row in VEHICLES.values():
        assert vehicle_row(row.name) is row
    assert vehicle_row("auv").granularity.depth == 1.0
    assert vehicle_row("auv").granularity.heading == pytest.approx(0.0174533)
    with pytest.raises(UnknownVehicle, match="no vehicle 'zeppelin'; there are: auv"):
        vehicle_row("zeppelin")
