"""The line of a console: what goes before what on one connection."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import AsyncIterator, Callable

import pytest
from served import PATIENCE

from mission.console.latency import Latency
from mission.console.line import AGAIN_S, Line
from mission.console.orders import Orders
from mission.topside.upload import Ask, NoAnswer, OperatorError, Script
from protocol.messages import DataQuery, StateReport
from protocol.topside import encode

KNOWN = dict.fromkeys(("report_age", "fix_age", "uncertainty_m", "north_m", "east_m", "to_depth_m"))
MORE = dict.fromkeys(("to_radius_m", "to_time", "to_voltage_v"))
STATE = encode(StateReport("idle/ready", "nobody", **KNOWN, **MORE, alarms=0, setpoint="", leg=""))


@contextlib.asynccontextmanager
async def line_to_nobody_who_answers() -> AsyncIterator[Line]:
    with socket.create_server(("127.0.0.1", 0)) as vehicle:
        line = Line(f"tcp://127.0.0.1:{vehicle.getsockname()[1]}")
        keeping = asyncio.ensure_future(line.keep())
        await until(lambda: line.is_open)
        try:
            yield line
        finally:
            keeping.cancel()
            await asyncio.gather(keeping, return_exceptions=True)


async def until(holds: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE):
        while not holds():
            await asyncio.sleep(0.01)


def without_end(begun: list[str]) -> Script:
    begun.append("begun")
    while True:
        yield Ask("status", DataQuery(), lambda _: False)


def at_once() -> Script:
    yield from ()
    return "done"


def test_what_is_asked_for_does_not_wait_for_a_look() -> None:
    async def told() -> None:
        async with line_to_nobody_who_answers() as line:
            begun: list[str] = []
            looks = [
                asyncio.ensure_future(line.say(without_end(begun), idle=True)) for _ in range(2)
            ]
            await until(lambda: begun == ["begun"])
            assert not line.is_busy
            async with asyncio.timeout(PATIENCE):
                assert await line.say(at_once()) == "done"
            for look in looks:
                with pytest.raises(OperatorError, match="look broke off"):
                    await look

    asyncio.run(told())


def test_a_look_waits_for_what_is_asked_for() -> None:
    async def told() -> None:
        async with line_to_nobody_who_answers() as line:
            asked = asyncio.ensure_future(line.say(without_end([])))
            look = asyncio.ensure_future(line.say(at_once(), idle=True))
            await asyncio.sleep(1.0)
            assert (asked.done(), look.done(), line.is_busy) == (False, False, True)
            asked.cancel()
            look.cancel()

    asyncio.run(told())


def test_the_way_is_measured_by_the_beat_and_its_slowest_answer_of_late_counts() -> None:
    latency = Latency(6.0)
    assert latency.patience_s == 6.0, "nothing was answered so far"
    for n in range(4):  # asked each second, answered 4 s later
        latency.asked(float(n))
    for n in range(4):
        assert latency.heard(STATE, 4.0 + n) is not None
    assert (latency.way_s, latency.patience_s) == (4.0, 1.0 + 4.0)
    for n in range(8):
        latency.asked(10.0 + n)
        latency.heard(STATE, 10.1 + n)
    assert latency.way_s == pytest.approx(0.1)


def test_what_was_asked_over_the_last_connection_measures_nothing_over_the_next() -> None:
    latency = Latency(6.0)
    latency.asked(0.0)
    latency.connected()
    latency.heard(STATE, 60.0)
    assert latency.way_s == 0.0


def test_a_program_that_tells_no_state_is_waited_for_as_ever() -> None:
    latency = Latency(6.0)
    for n in range(200):
        latency.asked(float(n))
        latency.heard(b"@AQS000000$", n + 0.1)
    assert latency.patience_s == 1.0


def test_a_line_opens_while_whatever_else_runs_in_threads_waits() -> None:
    async def told() -> None:
        over = threading.Event()
        waiting = [asyncio.ensure_future(asyncio.to_thread(over.wait)) for _ in range(64)]
        try:
            async with line_to_nobody_who_answers() as line:
                assert line.is_open
        finally:
            over.set()
            await asyncio.gather(*waiting)

    asyncio.run(told())


def test_a_vehicle_that_turns_the_line_away_is_not_asked_again_without_rest() -> None:
    turned_away: list[float] = []

    async def turn_away(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        turned_away.append(asyncio.get_running_loop().time())
        writer.close()

    async def told() -> None:
        vehicle = await asyncio.start_server(turn_away, "127.0.0.1", 0)
        line = Line(f"tcp://127.0.0.1:{vehicle.sockets[0].getsockname()[1]}")
        keeping = asyncio.ensure_future(line.keep())
        await until(lambda: len(turned_away) == 3)
        keeping.cancel()
        await asyncio.gather(keeping, return_exceptions=True)
        vehicle.close()

    asyncio.run(told())
    assert turned_away[2] - turned_away[0] >= 1.9 * AGAIN_S


@pytest.mark.parametrize("urgent", [False, True])
def test_what_waits_when_the_connection_is_lost_is_said_over_the_next_if_it_is_urgent_alone(
    urgent: bool,
) -> None:
    connected: list[asyncio.StreamWriter] = []

    async def says_nothing(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        connected.append(writer)

    async def told() -> None:
        vehicle = await asyncio.start_server(says_nothing, "127.0.0.1", 0)
        line = Line(f"tcp://127.0.0.1:{vehicle.sockets[0].getsockname()[1]}")
        keeping = asyncio.ensure_future(line.keep())
        await until(lambda: len(connected) == 1 and line.is_open)
        said = asyncio.ensure_future(line.say(without_end([])))
        begun: list[str] = []
        waits = asyncio.ensure_future(line.say(without_end(begun), urgent=urgent))
        await asyncio.sleep(0)
        connected[0].transport.abort()
        await until(lambda: len(connected) == 2 and line.is_open)
        await asyncio.wait([waits], timeout=1.0)
        assert (waits.done(), begun) == ((False, ["begun"]) if urgent else (True, []))
        keeping.cancel()
        failed = (await asyncio.gather(said, waits, keeping, return_exceptions=True))[1]
        assert ("not said" in str(failed)) != urgent
        for writer in connected:
            writer.transport.abort()
        vehicle.close()
        await asyncio.sleep(0)

    asyncio.run(told())


@pytest.mark.parametrize("under_water", [True, False])
def test_an_order_that_nobody_answers_is_said_again_by_radio_alone(under_water: bool) -> None:
    """By modem each X that arrives may put off that it is brought up."""

    class Silent:
        acoustics = object() if under_water else None
        asked = 0

        async def say(self, script: object, *, urgent: bool) -> str:
            self.asked += 1
            raise NoAnswer("no answer to stop")

    async def press() -> tuple[int, str]:
        line = Silent()
        orders = Orders(line)  # type: ignore[arg-type]
        orders.give("stop", lambda *_: None)
        for _ in range(40):
            await asyncio.sleep(0.05)
            if line.asked > 1:
                break
        found = line.asked, orders.as_objects(0.0)[0]["is"]
        orders.end()
        return found

    assert asyncio.run(press()) == ((1, "unconfirmed") if under_water else (2, "unanswered"))
