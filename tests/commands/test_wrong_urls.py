"""Laws of a URL that is none: it was said wrongly, and nobody is called silent for it."""

from __future__ import annotations

import socket

import pytest
from click.testing import CliRunner

from mission.cli import main

WRONG = {
    "nonsense": "is no link's URL",
    "tcp://boat:99999": "the port must be a number",
    "tcp://127.0.0.1": "write tcp://host:port",
    "serial://dev/ttyUSB0": "write three slashes",
    "tcp://boat:4000?colour=red": "unknown option 'colour'",
    "modem+serial:///dev/ttyUSB0?range=-1": "a number of m above 0",
}


@pytest.mark.parametrize("command", [
    ["status", "--to"], ["stop", "--to"], ["upload", "first-dive", "--to"], ["monitor"],
    ["watch", "--frames", "--to"],
])  # fmt: skip
@pytest.mark.parametrize(("url", "says"), WRONG.items())
def test_a_wrong_url_is_a_usage_error_and_no_silent_vehicle(
    command: list[str], url: str, says: str
) -> None:
    ran = CliRunner().invoke(main, [*command, url])
    assert ran.exit_code == 2
    assert says in ran.stderr
    assert "ALARM" not in ran.output


@pytest.mark.parametrize("command", [
    ["watch"], ["foxglove", "--to"], ["listen", "--link", "auv.from_stm32"],
    ["send", "--text", "@RI$", "--port"],
])  # fmt: skip
def test_a_url_without_its_port_is_opened_by_no_command(command: list[str]) -> None:
    ran = CliRunner().invoke(main, [*command, "tcp://127.0.0.1"])
    assert ran.exit_code == 2
    assert "write tcp://host:port, e.g. tcp://127.0.0.1:9000" in ran.stderr


def test_what_is_no_url_is_listened_to_by_nobody() -> None:
    ran = CliRunner().invoke(main, ["listen", "foo", "--link", "auv.from_stm32"])
    assert ran.exit_code == 2
    assert "'foo' is no link's URL" in ran.stderr


def test_a_port_that_says_nothing_is_no_monitor() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        ran = CliRunner().invoke(main, ["monitor", url, "--for", "0.1"])
    assert ran.exit_code == 1
    assert f"is {url} the operator's port?" in ran.stderr
