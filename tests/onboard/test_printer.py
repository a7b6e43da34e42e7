"""Nobody who reads, or does not read, what serve prints can hold up an order."""

from __future__ import annotations

import fcntl
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from ports import free_port
from served import read_now, silent_board, soon

from mission.onboard.serve.printer import PATIENCE_S, Printer

SMALLEST_PIPE = 4096


def small_pipe() -> tuple[int, int]:
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, SMALLEST_PIPE)
    return reader, writer


def test_lines_come_out_in_their_order_and_the_last_ones_before_the_end() -> None:
    reader, writer = os.pipe()
    printer = Printer(writer)
    for i in range(100):
        printer.print(f"line {i}")
    soon(printer.lines.empty, "the machine has come to print them")
    printer.close()
    os.close(writer)
    with os.fdopen(reader) as file:
        assert file.read().splitlines() == [f"line {i}" for i in range(100)]


def test_who_prints_to_somebody_that_reads_nothing_does_not_wait_and_is_told_the_loss() -> None:
    reader, writer = small_pipe()
    printer = Printer(writer, waiting=10)
    for _ in range(200):
        printer.print("x" * 1000)  # the pipe holds four of them
    printer.print("the last")
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 16 * SMALLEST_PIPE)  # somebody reads again
    soon(printer.lines.empty, "what waited is printed")
    printer.print("again")
    printer.close()
    os.close(writer)
    with os.fdopen(reader) as file:
        rows = file.read().splitlines()
    assert rows[-1] == "again"
    (lost,) = [row for row in rows if row.endswith("lines were lost here")]
    assert 150 < int(lost.split()[0]) < 200
    assert "the last" not in rows


def test_a_reader_that_is_gone_raises_nothing() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    printer = Printer(writer)
    for _ in range(10):
        printer.print("nobody hears it")
    printer.close()
    os.close(writer)


def test_the_end_does_not_wait_for_ever() -> None:
    reader, writer = small_pipe()
    printer = Printer(writer)
    printer.print("x" * 2 * SMALLEST_PIPE)
    printer.close()
    assert printer.thread.is_alive(), f"it stands in write(), and {PATIENCE_S:g} s were enough"
    os.close(reader)
    printer.thread.join()
    os.close(writer)


@pytest.mark.proof
def test_x_leaves_though_the_terminal_is_gone(tmp_path: Path) -> None:
    """As when serve was started over a radio that has gone: hung up, and nobody reads."""
    ready = tmp_path / "ready.json"
    port = free_port()
    reader, writer = os.pipe()
    with silent_board() as (master, device):
        call = [sys.executable, "-m", "mission", "serve", "--vehicle", f"serial://{device}"]
        call += ["--gps", "none", "--topside", f"tcp://127.0.0.1:{port}"]
        call += ["--folder", str(tmp_path), "--ready-file", str(ready)]
        with subprocess.Popen(call, stdout=writer, stderr=writer) as child:
            os.close(writer)
            try:
                soon(ready.exists, "ready")
                os.close(reader)
                child.send_signal(signal.SIGHUP)
                with socket.create_connection(("127.0.0.1", port)) as boat:
                    boat.sendall(b"@ZAX0$")
                    soon(lambda: b"@ZAX0$" in read_now(master), "X")
                assert child.poll() is None
            finally:
                child.terminate()
        assert child.returncode == 0
