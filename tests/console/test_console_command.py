"""`auvmission console` as its user runs it."""

from __future__ import annotations

import http.client
import json
import re
import signal
import sys
from pathlib import Path

import pytest
from programs import process, run
from served import PATIENCE, soon


def opened(line: str) -> tuple[str, str]:
    """Host and token of the address that is told."""
    found = re.fullmatch(r"open http://(127\.0\.0\.1:\d+)/#([\w-]{32,})\n", line)
    assert found, line
    return found[1], found[2]


def setup_of(host: str, token: str) -> dict[str, object]:
    asking = http.client.HTTPConnection(host, timeout=PATIENCE)
    asking.request("GET", "/api/setup", headers={"Authorization": f"Bearer {token}"})
    found = dict(json.loads(asking.getresponse().read()))
    asking.close()
    return found


@pytest.mark.proof
def test_several_vehicles_are_on_one_page_and_ctrl_c_ends_it() -> None:
    words = ["--to", "deck=tcp://127.0.0.1:1", "--to", "tls://[::1]:9?keys=keys"]
    with process("console", *words, "--no-browser") as console:
        assert console.stdout is not None
        shown = setup_of(*opened(console.stdout.readline()))["vehicles"]
        assert isinstance(shown, list)
        assert [(v["id"], v["name"], v["source"]) for v in shown] == [
            ("1", "deck", "monitor"),
            ("2", "[::1]:9", "monitor"),
        ]
        console.send_signal(signal.SIGINT)
        assert console.wait(PATIENCE) == 130


@pytest.mark.proof
def test_a_simulated_dive_is_under_way_when_the_page_opens(tmp_path: Path) -> None:
    words = ["--simulate", "float-test", "--no-browser", "--out", str(tmp_path / "out")]
    with process("console", *words) as console:
        assert console.stdout is not None
        told = [console.stdout.readline() for _ in range(3)]
        assert told[1] == "started\n"
        (shown,) = setup_of(*opened(told[2]))["vehicles"]  # type: ignore[misc]
        assert shown["name"] == "simulated auv"
        console.send_signal(signal.SIGTERM)
        assert console.wait(PATIENCE) == 128 + signal.SIGTERM
    soon(lambda: not (tmp_path / "out" / "vehicle").exists(), "its processes have ended")
    assert "the program is ended" in (tmp_path / "out" / "serve.log").read_text()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--to", "vehicle:4000"], "write e.g. tcp://vehicle:4000"),
        (["--to", "modem+serial:///dev/x?range=-1"], "range=-1"),
        (["--to", "tcp://a:1", "--monitor", "none", "--monitor", "none"], "2 monitors for 1"),
        (["nothing.mcap"], "nothing.mcap"),
        (["no-such-mission"], "no shipped mission"),
        (["--simulate", "no-such-mission"], "no shipped mission"),
        (["--simulate", "float-test", "--set", "depth=x"], "depth"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_words(words: list[str], why: str) -> None:
    ran = run("console", *words, "--no-browser")
    assert (ran.exit_code, why in ran.output) == (2, True), ran.output


def test_without_its_extra_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("mission.console")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "starlette", None)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    ran = run("console", "--no-browser")
    assert (ran.exit_code, "pip install 'auvmission[console]'" in ran.output) == (2, True)


def test_a_port_that_is_taken_is_told() -> None:
    import socket

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        ran = run("console", "--port", str(port), "--no-browser")
    assert (ran.exit_code, f"port {port}" in ran.output) == (2, True)
