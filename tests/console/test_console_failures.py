"""What fails in a console, or is said to it that nobody says, costs neither X nor W."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from console_world import Page, console_of
from served import PATIENCE, running, silent_board


@contextmanager
def monitor_that_says(frame: object) -> Iterator[str]:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def speak() -> None:
            viewer, _ = server.accept()
            with viewer:
                viewer.sendall(json.dumps(frame).encode() + b"\n")
                while viewer.recv(1000):
                    pass

        speaking = threading.Thread(target=speak, daemon=True)
        speaking.start()
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
    speaking.join(PATIENCE)


def test_a_value_that_nobody_can_read_ends_no_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    odd = {"ellipse": ["wide", 1, 2]}
    with (
        monitor_that_says({"n": 1, "t": 1.0, "state": odd}) as monitor,
        silent_board() as (_, board),
        running(tmp_path, f"serial://{board}") as pi,
        console_of(pi.url, tmp_path, monitor) as (console, _),
        console.socket("frames") as frames,
    ):
        page = Page(frames)
        page.until(lambda s: s.get("ellipse") == odd["ellipse"], "the odd value")
        later = time.monotonic() + 2.5
        page.until(lambda _: time.monotonic() > later, "it has been looked at")
        page.until(lambda s: s["lines"]["orders"] is not None, "the line of orders")
    assert "wide" in capfd.readouterr().err
    assert "wide" in (tmp_path / "console.jsonl").read_text()
