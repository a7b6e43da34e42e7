"""Each port is opened at the rate of its role: the document's, unless file or URL say otherwise."""

from __future__ import annotations

import json
import os
import pty
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from links import at_rate, open_link
from mission.commands.doctor import doctor
from mission.model.shipped import missions_folder
from mission.onboard.rates import rated
from mission.onboard.serve.provision import provide

SHIPPED = sorted(path.stem for path in (missions_folder() / "vehicles").glob("*.yaml"))
ON_A_BUS = ("motorboards", "mainboard")
VEHICLES = [name for name in SHIPPED if name not in ON_A_BUS]
ROLES = ("vehicle", "gps", "modem")
SPEEDS = {getattr(termios, f"B{n}"): n for n in (4800, 9600, 19200, 57600, 115200)}
NOTHING = dict.fromkeys(("vehicle", "gps", "topside", "modem"))


@pytest.fixture
def ports() -> Iterator[dict[str, str]]:
    """A pseudo-terminal for each role; other rates than any role's are set before."""
    opened = {role: pty.openpty() for role in ROLES}
    for _, slave in opened.values():
        attributes = termios.tcgetattr(slave)
        attributes[4] = attributes[5] = termios.B57600
        termios.tcsetattr(slave, termios.TCSANOW, attributes)
    yield {role: os.ttyname(slave) for role, (_, slave) in opened.items()}
    for fds in opened.values():
        for fd in fds:
            os.close(fd)


def configured(folder: Path, ports: dict[str, str], vehicle: str, options: str = "") -> Path:
    config = folder / "serve.yaml"
    links = "".join(f"  {role}: serial://{path}{options}\n" for role, path in ports.items())
    config.write_text(f"vehicle: {vehicle}\nfolder: {folder / 'pi'}\nlinks:\n{links}")
    return config


def speed(port: str) -> int:
    fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        _, _, _, _, heard, said, _ = termios.tcgetattr(fd)
    finally:
        os.close(fd)
    assert heard == said
    return SPEEDS[said]


def opened(config: Path) -> dict[str, int]:
    """The rates as the driver has them, once serve's links are open."""
    links = provide(config, NOTHING, None, {}).configuration.links
    found = {}
    for role in ROLES:
        link = open_link(role, getattr(links, role))
        found[role] = speed(link.device)  # type: ignore[attr-defined]
        link.close()
    return found


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_every_port_is_opened_at_the_rate_of_its_role(
    vehicle: str, tmp_path: Path, ports: dict[str, str]
) -> None:
    config = configured(tmp_path, ports, vehicle)
    wanted = 9600 if vehicle.startswith("auv") else 115200
    assert opened(config) == {"vehicle": wanted, "gps": 9600, "modem": 115200}


@pytest.mark.parametrize("vehicle", VEHICLES)
def test_a_rate_that_the_url_tells_is_kept(
    vehicle: str, tmp_path: Path, ports: dict[str, str]
) -> None:
    config = configured(tmp_path, ports, vehicle, "?baud=19200")
    assert opened(config) == dict.fromkeys(ROLES, 19200)


def test_a_board_of_another_rate_says_so_in_its_vehicle_file(
    tmp_path: Path, ports: dict[str, str]
) -> None:
    """E-V: an older robot opens 9600."""
    shipped = (missions_folder() / "vehicles" / "robot.yaml").read_text()
    other = tmp_path / "robot.yaml"
    assert shipped.count("wire: {") == 1
    other.write_text(shipped.replace("wire: {", "wire: {baud: 9600, "))
    config = configured(tmp_path, ports, str(other))
    assert opened(config) == {"vehicle": 9600, "gps": 9600, "modem": 115200}


def test_doctor_shows_the_rate_at_which_it_opened_each_port(
    tmp_path: Path, ports: dict[str, str]
) -> None:
    config = configured(tmp_path, ports, "robot")
    found = json.loads(CliRunner().invoke(doctor, ["-c", str(config), "--json"]).stdout)
    says = {one["what"]: one["says"] for one in found["findings"]}
    assert f"serial://{ports['vehicle']}?baud=115200" in says["vehicle port"]
    assert f"serial://{ports['gps']}?baud=9600" in says["GPS port"]
    assert f"serial://{ports['modem']}?baud=115200" in says["modem port"]


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("serial:///dev/x", "serial:///dev/x?baud=19200"),
        ("serial:///dev/x?baud=300", "serial:///dev/x?baud=300"),
        ("can://can0", "can://can0?bitrate=19200"),
        ("can://can0?interface=virtual", "can://can0?interface=virtual&bitrate=19200"),
        ("tcp://127.0.0.1:9", "tcp://127.0.0.1:9"),
        ("memory://wire", "memory://wire"),
        ("no link", "no link"),
    ],
)
def test_only_a_line_that_needs_a_rate_and_tells_none_is_given_one(url: str, told: str) -> None:
    assert at_rate(url, 19200) == told


def test_what_is_rated_once_is_rated(tmp_path: Path, ports: dict[str, str]) -> None:
    got = provide(configured(tmp_path, ports, "rov"), NOTHING, None, {})
    assert rated(got.configuration, got.vehicle) == got.configuration
