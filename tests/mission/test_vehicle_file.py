"""Vehicle files: what is wrong in one is said with file, key and what there is instead."""

from __future__ import annotations

from pathlib import Path

import pytest

from mission.vehicle import FOLLOWS, REPORTS, VehicleError, load_vehicle, missions_folder

SHIPPED = sorted((missions_folder() / "vehicles").glob("*.yaml"))
AUV = (missions_folder() / "vehicles" / "auv.yaml").read_text(encoding="utf-8")


def loaded(folder: Path, old: str, new: str) -> object:
    assert AUV.count(old) == 1
    path = folder / "mine.yaml"
    path.write_text(AUV.replace(old, new), encoding="utf-8")
    return load_vehicle(path)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_a_shipped_file_says_of_every_sensor_and_axis_whether_it_is_there(path: Path) -> None:
    vehicle = load_vehicle(path)
    text = path.read_text(encoding="utf-8")
    for name in REPORTS | FOLLOWS:
        assert f"\n  {name}: " in text, name
    assert vehicle.reports <= REPORTS
    assert vehicle.follows <= FOLLOWS


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("dive_rate: 0.35", "diverate: 0.35", "diverate"),
        ("  voltage: 10 V", "  volts: 10 V", "limits: no key volts; there are depth"),
        ("  leak: false", "  leek: true", "reports: no key leek; there are altitude"),
        ("  attitude: false", "  yaw: true", "follows: no key yaw"),
        ("bias_deg: 0.0", "bias: 0.0", "compass: no key bias"),
        ("power: 1.0}", "thrusters: 1.0}", "battery_scale: no key thrusters"),
        ("hotel: 35", "house: 35", "battery: no key house"),
        ("  fix: 2.5 m", "  gps: 2.5 m", "sensors: no key gps"),
        ("  turn_slip: 1.8 s", "  slip: 1.8 s", "calibration: no key slip"),
    ],
)
def test_a_key_nobody_knows_is_refused_with_those_there_are(
    tmp_path: Path, old: str, new: str, named: str
) -> None:
    with pytest.raises(VehicleError, match=named):
        loaded(tmp_path, old, new)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("codec: auv", "codec: submarine", "codec: no vehicle 'submarine'; there are: auv"),
        ("dialect: as-built ", "dialect: spoken ", "codec: no dialect 'spoken' of auv"),
        ("tolerances: {}", "tolerances: {sd: on}", "codec: no tolerance 'sd'"),
    ],
)
def test_what_no_codec_knows_is_refused_when_the_file_is_read(
    tmp_path: Path, old: str, new: str, named: str
) -> None:
    with pytest.raises(VehicleError, match=named):
        loaded(tmp_path, old, new)


def test_a_dialect_belongs_to_its_codec(tmp_path: Path) -> None:
    rov = (missions_folder() / "vehicles" / "rov.yaml").read_text(encoding="utf-8")
    path = tmp_path / "rov.yaml"
    path.write_text(rov.replace("dialect: documented", "dialect: as-built"), encoding="utf-8")
    with pytest.raises(VehicleError, match="no dialect 'as-built' of rov; there are: documented"):
        load_vehicle(path)
