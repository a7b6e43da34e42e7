"""The laws of the line over the whole runtime: no mix of what operators send keeps a safety word, a
stop or the set that is due from the vehicle (R7, R12, R14)."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from links.base import Rx
from mission.authoring.language import parse, script
from mission.model import AUTONOMOUS, STOPPED, SURFACING, Position, Tx
from mission.model.shipped import load_vehicle
from mission.navigation import Navigation
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.frontseat import GAP_S
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore, Stored
from mission.verification.campaign.audit import command_of
from mission.verification.exhaustive.world import BOAT, TENDER, World
from protocol.messages import Order
from protocol.vehicles import codec
from protocol.vehicles.auv import AuvCodec

BYTE = 10 / 9600  # s
FRAME = 17 * BYTE + GAP_S  # the longest that operators have passed on
TRIES = 0.9  # s that a frame without an answer keeps the next one back
X, W = b"@ZAX0$", b"@ZAWF$"
TEXT = """\
mission pool vehicle auv
safety radius 200 time 5min depth 5
start without fix
a: depth 2 heading 0 gear 4 for 20
"""
LINES = tuple(script(parse(TEXT)))
SLIDERS = (
    [b"@DS1,%d$" % i for i in range(-15, 23)],
    [b"@DS%d,%d$" % (i % 3 + 1, i) for i in range(20)],
    [b"@DA1,1$", b"@DA2,-1$"],
    [b"@RI$", b"@RSOOOOOOO$", b"@DS3,%d$" % 5, b"@DA3,1$"],
    [b"@DS3,00005$", b"@RSOOOOOOC$"],
)
HERE = Position(30.0, 120.0)
FLOODS = (b"@RI$" * 50, b"@DU$@AQ$@NI$" * 20, b"@AA$" * 30, b"\xff" * 400, b"@AW\x01\x00", b"@SP,1")
ORDERS = ("X", "W", "tender X", "tender W", "modem X", "modem W")


VEHICLE = replace(load_vehicle("auv"), dialect="as-built")


def under_way(answers: str = "Y") -> World:
    """In a mission's first leg, all of whose set was accepted."""
    world = World(VEHICLE, Stored(lines=LINES), HERE)
    world.navigate(Navigation(VEHICLE))
    world.wait(6.0)
    world.say(b"@AQ$@AA$")
    world.wait(1.0)
    assert world.state.startswith(AUTONOMOUS)
    world.answers = answers
    return world


def say(world: World, said: str) -> None:
    """An X or a W, by whom it names."""
    frame = X if said.endswith("X") else W
    if said.startswith("modem"):
        world.say_below(frame)
    else:
        world.say(frame, TENDER if said.startswith("tender") else BOAT)


def left(world: World, since: float = 0.0) -> list[Tx]:
    return [tx for tx in world.sent if tx.link == "vehicle" and tx.t >= since]


def slide(world: World, words: list[bytes], rate: float, seconds: float) -> None:
    """A slider that is moved: one word after the other."""
    end, i = world.now + seconds, 0
    while world.now < end:
        world.say(words[i % len(words)])
        world.wait(min(1.0 / rate, end - world.now))
        i += 1


def late(world: World) -> list[str]:
    """What did not leave in time: of each Step's commands, until a newer Step has others."""
    found = []
    told = [(s.t, command_of(w)) for s in world.notes.steps for w in s.actions]
    ends = [t for t, _ in told[1:]] + [world.now]
    for (t, command), end in zip(told, ends, strict=True):
        due = t + FRAME
        for i, frame in enumerate(AuvCodec("as-built").encode(command)):
            due += (TRIES + FRAME if i else 0.0) if isinstance(command, Order) else TRIES + FRAME
            leaves = [tx.t for tx in left(world, t - 1e-6) if tx.data == frame]
            if due <= end and not (leaves and leaves[0] <= due):
                found.append(f"{frame!r} of {t:.2f} s by {due:.2f} s: {leaves[:1]}")
    return found


def too_close(world: World) -> list[tuple[Tx, Tx]]:
    return [
        (a, b) for a, b in pairwise(left(world)) if b.t - a.t < len(a.data) * BYTE + GAP_S - 1e-6
    ]


@pytest.mark.parametrize("answers", ["Y", "N", ""])
@pytest.mark.parametrize("rate", [5, 20, 60, 200])
def test_a_slider_keeps_no_half_of_an_ascent_back(rate: int, answers: str) -> None:
    """Seen at sea in a second simulation: X0 left, and U12 never, while a rudder was moved."""
    world = under_way(answers)
    world.sea.depth = 3.0
    slide(world, SLIDERS[0], rate, 1.0)
    world.say(W)
    slide(world, SLIDERS[0], rate, 24.0)
    assert world.state == SURFACING
    turns = [tx for tx in left(world) if tx.data == b"@ZAU12$"]
    assert turns
    before = next(tx for tx in reversed(left(world)) if tx.data == X and tx.t < turns[0].t)
    assert turns[0].t - before.t <= TRIES + FRAME
    assert late(world) == []


@pytest.mark.parametrize("rate", [5, 20, 60, 200])
def test_each_leg_s_set_leaves_under_a_slider(rate: int) -> None:
    world = under_way()
    slide(world, SLIDERS[1], rate, 30.0)
    assert late(world) == []
    assert len([s for s in world.notes.steps if s.entered]) > 1


def test_a_slider_s_last_word_is_the_last_that_leaves_and_no_old_one_follows_it() -> None:
    world = under_way()
    slide(world, SLIDERS[0], 200, 4.0)
    world.say(b"@DS1,0$")
    world.wait(2 * FRAME)
    rudders = [tx for tx in left(world) if tx.data.startswith(b"@DS1")]
    assert rudders[-1].data == b"@DS1,0$"
    assert rudders[-1].t <= world.now - 2 * FRAME + 2 * FRAME
    world.wait(2.0)
    assert [tx.data for tx in left(world) if tx.data.startswith(b"@D")][-1] == b"@DS1,0$"


def test_who_asks_for_more_steps_of_a_rudder_than_the_line_takes_is_told() -> None:
    world = under_way()
    before = len(world.sent)
    for _ in range(20):
        world.say(b"@DA1,1$")
    world.wait(2.0)
    told = [tx for tx in world.sent[before:] if tx.link == "topside" and b"increments" in tx.data]
    assert [tx.address for tx in told] == [BOAT]
    steps = [tx for tx in left(world) if tx.data == b"@DA1,1$"]
    assert 8 <= len(steps) <= 9


_EVENTS = st.one_of(
    st.tuples(st.just("slider"), st.sampled_from(SLIDERS), st.sampled_from([5, 20, 60, 200])),
    st.tuples(
        st.just("flood"), st.sampled_from(FLOODS), st.sampled_from(["boat", "tender", "modem"])
    ),
    st.tuples(st.just("order"), st.sampled_from(ORDERS), st.just(0)),
    st.tuples(st.just("stick"), st.sampled_from([b"@MMF5$", b"@MMF0$", b"@MT3,-12$"]), st.just(0)),
)


@pytest.mark.proof
@settings(max_examples=40, deadline=None)
@given(st.lists(_EVENTS, min_size=1, max_size=8), st.sampled_from(["Y", "N", ""]))
def test_no_mix_of_sliders_floods_orders_and_sticks_keeps_anything_back(script, answers) -> None:
    world = under_way(answers)
    for kind, what, how in script:
        began = world.now
        if kind == "slider":
            slide(world, what, how, 2.0)
        elif kind == "stick":
            world.say(what)
            world.wait(0.2)
        elif kind == "flood" and how == "modem":
            world.hear_modem(what)
        elif kind == "flood":
            world.say(what, TENDER if how == "tender" else BOAT)
            world.wait(0.06)
        else:
            say(world, what)
            world.wait(0.1)
            frame = X if what.endswith("X") else W
            assert frame in [tx.data for tx in left(world, began)], what
            assert world.state == (STOPPED if frame == X else SURFACING)
    world.wait(2.0)
    assert late(world) == []
    assert too_close(world) == []


# --- boards that acknowledge nothing -----------------------------------------------------------


@pytest.mark.parametrize("name", ["coreboard", "rov", "robot"])
@pytest.mark.parametrize("baud", [9600, 115200])
def test_a_board_that_acknowledges_nothing_hears_a_stop_behind_one_set_at_most(
    name: str, baud: int
) -> None:
    """Sliders, sticks and a thousand orders: what leaves is what the line carries."""
    url = f"serial:///dev/none?baud={baud}"
    configuration = Configuration(links=replace(Configuration().links, vehicle=url))
    runtime = Runtime(configuration, load_vehicle(name), MemoryStore())
    sent: list[Tx] = runtime.connected("topside", BOAT, 0.0)
    for i in range(1000):
        now = i * 0.002
        due = runtime.next_timer()
        while due is not None and due <= now:
            sent += runtime.handle_timer(due)
            due = runtime.next_timer()
        said = (b"@MMF5$", b"@DS1,5$", b"@RI$", W, X)[i % 5]
        sent += runtime.receive(Rx(now, "topside", said, BOAT))
    ours = [tx for tx in sent if tx.link == "vehicle"]
    assert not [tx for tx in ours if tx.data.startswith(b"@")]
    carried = sum(len(tx.data) for tx in ours[:-2]) * 10 / baud
    assert carried <= ours[-1].t - ours[0].t + 1e-6
    assert runtime.state == STOPPED
    set_s = 2 * max(len(tx.data) for tx in ours) * 10 / baud
    assert runtime.next_timer() <= 2.0 + set_s


@pytest.mark.parametrize("name", ["coreboard", "rov", "robot"])
@pytest.mark.parametrize(
    "word",
    [
        b"@MT1,5$",
        b"@MDS1,5$",
        b"@MS50,90$",
        b"@MP50,90$",
        b"@MRU3$",
        b"@DS1,5$",
        b"@RSOOOOOOO$",
        b"@RI$",
    ],
)
def test_a_vehicle_without_m_r_and_d_is_changed_by_none_of_them(name: str, word: bytes) -> None:
    runtime = Runtime(Configuration(), load_vehicle(name), MemoryStore())
    runtime.connected("topside", BOAT, 0.0)
    before = runtime.state
    told = runtime.receive(Rx(1.0, "topside", b"@AQ$", BOAT))
    answered = runtime.receive(Rx(2.0, "topside", word, BOAT))
    (said,) = [tx for tx in answered if tx.link == "topside"]
    assert b"relay: this vehicle has no " in said.data
    assert told
    assert runtime.state == before
    neutral = codec(*load_vehicle(name).speaks).encode(Order.STOP)
    left = [tx.data for tx in runtime.handle_timer(3.0) if tx.link == "vehicle"]
    assert left == (neutral if name == "coreboard" else [])


@pytest.mark.parametrize("name", ["auv", "coreboard", "rov", "robot"])
def test_in_idle_the_core_board_alone_is_told_neutral_and_ten_times_a_second(name: str) -> None:
    """R16: byte 43 of each frame powers its INS, and nobody has asked for anything yet."""
    vehicle = load_vehicle(name)
    runtime = Runtime(Configuration(), vehicle, MemoryStore(Stored()))
    sent: list[Tx] = []
    while (due := runtime.next_timer()) is not None and due < 2.95:
        sent += runtime.handle_timer(due)
    neutral = [codec(*vehicle.speaks).encode(Order.STOP)[0]] if name == "coreboard" else []
    assert [tx.data for tx in sent] == neutral * 30
    assert runtime.state == "idle/empty"
