"""What is shipped for the Pi is what the tests have measured, and what is documented exists."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
from dataclasses import fields
from pathlib import Path

import pytest
from test_survival import FIRST_W_S, RESTART_S

from links import LINKS, parse_address
from mission.cli import COMMANDS
from mission.onboard.configuration import Configuration, LinkUrls

ROOT = Path(__file__).resolve().parents[2]
UNIT = ROOT / "deploy" / "auvmission.service"
MANUAL = ROOT / "docs" / "operation.md"


def unit() -> configparser.ConfigParser:
    parser = configparser.ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    parser.read_string(UNIT.read_text(encoding="ascii"))
    return parser


def test_the_unit_is_watched_and_starts_serve_again_for_ever() -> None:
    service = unit()["Service"]
    assert service["Type"] == "notify"
    assert service["Restart"] == "always"
    assert float(service["RestartSec"]) == RESTART_S < FIRST_W_S
    assert 0 < float(service["WatchdogSec"]) < 60
    assert unit()["Unit"]["StartLimitIntervalSec"] == "0"
    assert " serve --config " in service["ExecStart"]


def test_a_camera_that_is_killed_for_its_memory_ends_no_mission() -> None:
    """It runs in the unit, and what the manager does by itself then is stop."""
    assert unit()["Service"]["OOMPolicy"] == "continue"


def test_the_service_manager_finds_no_fault_in_the_unit(tmp_path: Path) -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd is not here")
    text = re.sub(r"ExecStart=\S+", "ExecStart=/bin/true", UNIT.read_text(encoding="ascii"))
    (tmp_path / UNIT.name).write_text(text)
    ran = subprocess.run(
        ["systemd-analyze", "verify", str(tmp_path / UNIT.name)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert [line for line in ran.stderr.splitlines() if "auvmission" in line] == []


def test_every_key_of_the_configuration_is_documented() -> None:
    rows = re.findall(r"^\| `([a-z0-9_.]+)` \|", MANUAL.read_text(encoding="utf-8"), re.MULTILINE)
    keys = [f.name for f in fields(Configuration) if f.name not in ("links", "ascent_only")]
    assert sorted(rows) == sorted([*keys, *(f"links.{f.name}" for f in fields(LinkUrls))])


def test_every_link_and_command_in_the_manual_exists() -> None:
    text = MANUAL.read_text(encoding="utf-8")
    for url in re.findall(r"`((?:tls|tcp)-listen://[^`]+)`", text):
        assert parse_address(url).scheme in LINKS
    for command in re.findall(r"auvmission ([a-z]+)\b", text):
        assert command in COMMANDS or command in ("serve", "and"), command
