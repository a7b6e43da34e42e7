"""Laws of --json: what a command prints on standard output is data, whole, and nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from served import running, simulated

from mission.cli import COMMANDS, main

RECORDED = Path(__file__).parents[1] / "analysis" / "recorded" / "short-time.mcap"
HOP = """\
mission hop vehicle auv
home 30.2874595 120.1535765
safety radius 500 time 15min depth 10 voltage 10
assume current 0.2
start without fix
dive: depth 2 heading 0 gear 6 until depth >= 1.5 timeout 90
up: surface timeout 3min
"""
SEEN_ELSEWHERE = {
    "exhaustive": "minutes: tests/verification/test_exhaustive.py",
    "faults": "a campaign: tests/verification/test_cluster.py",
    "listen": "one object a line: tests/commands/test_listen.py",
    "report": "draws: tests/analysis/test_report.py",
    "vehicle": "runs until ctrl-C: tests/commands/test_vehicle_command.py",
    "water": "runs until ctrl-C: tests/commands/test_water_command.py",
}
AT_THE_DESK = {
    "simulate": "{mission}",
    "rehearse": "{mission} --flights 1 --on local",
    "check": "{mission}",
    "diff": "{mission} {mission}",
    "log": "{log}",
    "replay": "{log}",
    "decode": "--link auv.to_stm32 {frames}",
    "find-crc": "{frames}",
    "doctor": "-c {none}",
    "convert": "{mission}",
    "fmt": "{mission} --check",
    "graph": "{mission} -o graph.svg",
    "plan": "{mission} -o plan.geojson",
    "keys": "keys",
    "export": "{log} -o out --as csv",
}
ON_THE_BOAT = {
    "upload": "{mission}",
    "start": "",
    "clear": "",
    "status": "",
    "stop": "",
    "surface": "",
    "limits": "--depth 8",
    "time": "",
    "nodes": "",
    "power": "",
    "rudder": "left 2",
    "output": "lamp 40",
    "send": "DU",
}


def test_every_command_with_json_is_in_one_of_these_tables() -> None:
    def takes_json(name: str) -> bool:
        command = main.get_command(click.Context(main), name)
        return command is not None and any("--json" in one.opts for one in command.params)

    tables = (SEEN_ELSEWHERE, AT_THE_DESK, ON_THE_BOAT)
    assert sorted(name for table in tables for name in table) == sorted(
        filter(takes_json, COMMANDS)
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("json")
    (folder / "hop.mission").write_text(HOP, encoding="utf-8")
    (folder / "frames").write_bytes(b"@ZAX0$@ZAQ@RI$")
    names = {"mission": "hop.mission", "frames": "frames", "none": "none.yaml"}
    return {"log": str(RECORDED)} | {name: str(folder / file) for name, file in names.items()}


@pytest.fixture(scope="module")
def pi(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a serve whose vehicle is on its line."""
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path_factory.mktemp("pi"), stm32, gps=gps, speed=4.0) as server:
            yield server.url


def says_data(name: str, words: str) -> list[object]:
    """All that it prints: one JSON value, or one a line."""
    ran = CliRunner().invoke(main, [name, *words.split(), "--json"])
    assert ran.exception is None or isinstance(ran.exception, SystemExit), ran.exception
    found = [json.loads(line) for line in ran.stdout.splitlines()]
    assert found, f"exit {ran.exit_code}: {ran.stderr}"
    assert all(isinstance(one, dict | list) for one in found)
    return found


@pytest.mark.parametrize("name", AT_THE_DESK)
def test_a_command_of_the_desk_prints_data_and_nothing_else(
    name: str, files: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    says_data(name, AT_THE_DESK[name].format(**files))


@pytest.mark.parametrize("name", ON_THE_BOAT)
def test_a_command_of_the_boat_prints_one_object_and_nothing_else(
    name: str, files: dict[str, str], pi: str
) -> None:
    (said,) = says_data(name, f"{ON_THE_BOAT[name].format(**files)} --to {pi}")
    assert isinstance(said, dict)
