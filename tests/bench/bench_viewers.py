"""What ten slow viewers cost: a report's answer, and an X, with them and without.

    python tests/bench/bench_viewers.py [rounds]

`serve` in a process of its own. Ten viewers wish for everything five times a second, read it, and
answer each frame a second late, as over a thin radio. Rounds with and without them take turns, so
that whatever else the machine does meets both alike. Beside it the same program without viewers
twice: how far two halves of the same differ is the noise.
"""

from __future__ import annotations

import json
import re
import select
import socket
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench"), str(ROOT / "tests" / "worlds")]

from bench_latency import MISSION, Board, serving  # noqa: E402
from ports import free_port  # noqa: E402

from mission.authoring.language import digest, parse, script  # noqa: E402
from mission.topside.console import converse  # noqa: E402
from mission.topside.monitor import wish  # noqa: E402
from mission.topside.upload import OperatorError, Script, start, upload  # noqa: E402

VIEWERS, SLOW_S = 10, 1.0
REPORTS, ORDERS, PAUSE_S, PATIENCE = 12, 6, 0.12, 20
NUMBER = re.compile(rb'"n":(\d+)')


@contextmanager
def watched(port: int, viewers: int) -> Iterator[None]:
    """By so many who answer late."""
    over = threading.Event()
    thread = threading.Thread(target=_view, args=(port, viewers, over))
    thread.start()
    time.sleep(1.5)  # they have all been sent what was before
    try:
        yield
    finally:
        over.set()
        thread.join()


def _view(port: int, viewers: int, over: threading.Event) -> None:
    sockets = [socket.create_connection(("127.0.0.1", port)) for _ in range(viewers)]
    for one in sockets:
        one.sendall(wish())
    heard: dict[socket.socket, bytes] = dict.fromkeys(sockets, b"")
    late: list[tuple[float, socket.socket, bytes]] = []
    while not over.is_set():
        for one in select.select(sockets, [], [], 0.05)[0]:
            *lines, heard[one] = (heard[one] + one.recv(65536)).split(b"\n")
            answered = time.monotonic() + SLOW_S
            numbers = (found for line in lines if (found := NUMBER.search(line)))
            late += [(answered, one, found[1]) for found in numbers]
        now = time.monotonic()
        for _, one, number in [x for x in late if x[0] <= now]:
            one.sendall(b'{"ack":%s}\n' % number)
        late = [x for x in late if x[0] > now]
    for one in sockets:
        one.close()


def main(rounds: int = 8) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as name:
        board, folder, port = Board(), Path(name), free_port()
        (folder / "serve.yaml").write_text(
            f"links: {{monitor: 'tcp-listen://127.0.0.1:{port}?each=20'}}\n"
        )
        with serving(board, folder, f"--config={folder / 'serve.yaml'}") as (_, address):
            fly_on(board, address)
            kinds = ("without", "with", "without again")
            answers: dict[str, list[float]] = {kind: [] for kind in kinds}
            orders: dict[str, list[float]] = {kind: [] for kind in kinds}
            for _ in range(rounds):
                for kind in kinds:
                    with watched(port, VIEWERS if kind == "with" else 0):
                        answers[kind] += _answers(board)
            for _ in range(rounds):
                for kind in kinds:
                    with watched(port, VIEWERS if kind == "with" else 0):
                        orders[kind] += orders_of(board, address)
        board.close()
    return _told("@SD to @ZA", answers, "viewers_report_ms") | _told("X", orders, "viewers_x_ms")


def _told(what: str, found: dict[str, list[float]], key: str) -> dict[str, float]:
    middle = {kind: 1e3 * statistics.median(taken) for kind, taken in found.items()}
    worst = {kind: 1e3 * max(taken) for kind, taken in found.items()}
    rows = (f"{kind} {middle[kind]:.2f} ms (worst {worst[kind]:.1f})" for kind in found)
    sys.stdout.write(f"{what}, median of {len(found['with'])}: {', '.join(rows)}\n")
    return {key: middle["with"] - middle["without"]}


def fly_on(board: Board, address: str) -> None:
    mission = parse(MISSION)
    lines, whole = script(mission), digest(mission)
    _until_done(board, address, lambda: upload(lines, whole, lambda have, total: None))
    _until_done(board, address, start)
    board.quiet(0.5)


def _until_done(board: Board, address: str, talk: Callable[[], Script]) -> None:
    """By a vehicle that has found itself. A busy machine may take longer than an operator's tries,
    and then reports and fixes are old."""
    for last in (*[False] * PATIENCE, True):
        for _ in range(8):
            board.fix()
            board.report(90.0)
            board.quiet(0.4)
        try:
            converse(address, talk())
        except OperatorError:
            if last:
                raise
            continue
        return


def _answers(board: Board) -> list[float]:
    """s from the last byte of a report to the first of what follows from it."""
    found = []
    for n in range(REPORTS):
        asked = board.report(80.0 if n % 2 else 100.0)
        answered = board.listen(1.0)
        if answered is not None:  # the leg was entered by a report of the round before
            found.append(answered - asked)
        board.quiet(PAUSE_S)
    return found


def orders_of(board: Board, address: str) -> list[float]:
    """s from an X of the boat to its first byte at the board."""
    host, port = address.removeprefix("tcp://").split(":")
    found = []
    with socket.create_connection((host, int(port))) as boat:
        for _ in range(ORDERS):
            board.quiet(0.7)  # an acknowledged X is said no more
            asked = time.monotonic()
            boat.sendall(b"@ZAX0$")
            answered = board.listen(5.0)
            assert answered is not None, "an X that does not arrive"
            found.append(answered - asked)
    return found


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(*map(int, sys.argv[1:]))) + "\n")
