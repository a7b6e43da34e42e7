"""The laws of what operators pass on, while it waits for the line (R6, R14)."""

from __future__ import annotations

import re
from collections import defaultdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mission.onboard.runtime.relays import INCREMENTS, Relays

MOST = 23  # words: 5 thrusters, 2 groups of them, 3 sorts of servo twice, RS, RI, 8 increments


def add(relays: Relays, *frames: bytes) -> list[str]:
    return [relays.add(frame, "relay", frame.startswith(b"@M")) for frame in frames]


def left(relays: Relays) -> list[bytes]:
    return [relays.take()[0] for _ in range(len(relays))]


def of(*frames: bytes) -> list[bytes]:
    """What leaves of these."""
    relays = Relays()
    assert not any(add(relays, *frames))
    return left(relays)


@pytest.mark.parametrize(
    ("said", "leaves"),
    [
        ((b"@DS1,10$", b"@DS1,12$"), (b"@DS1,12$",)),
        ((b"@DS1,10$", b"@DS2,12$"), (b"@DS1,10$", b"@DS2,12$")),
        ((b"@DS1,10$", b"@DS2,5$", b"@DS3,0$"), (b"@DS3,0$",)),
        ((b"@DS3,10$", b"@DS1,12$"), (b"@DS3,10$", b"@DS1,12$")),
        ((b"@DS1,1$", b"@RI$", b"@DS1,2$"), (b"@DS1,2$", b"@RI$")),
        ((b"@RSOOOOOOO$", b"@RSCOOOOOO$", b"@RI$", b"@RI$"), (b"@RSCOOOOOO$", b"@RI$")),
        ((b"@MT1,5$", b"@MT2,5$", b"@MT1,-5$"), (b"@MT1,-5$", b"@MT2,5$")),
        ((b"@MT1,5$", b"@MT3,5$", b"@MMF0$"), (b"@MMF0$", b"@MT3,5$")),
        ((b"@MMF9$", b"@MT1,5$", b"@MMF0$"), (b"@MMF0$",)),
        ((b"@MMF9$", b"@MMD9$", b"@MMB2$"), (b"@MMB2$", b"@MMD9$")),
        ((b"@MMF9$", b"@MS120,90$", b"@MMF0$"), (b"@MMF0$",)),
        ((b"@MRL5$", b"@MRF5$", b"@MP120,90$"), (b"@MRL5$", b"@MP120,90$")),
        ((b"@MT1,5$", b"@MMF9$", b"@MT1,7$"), (b"@MMF9$", b"@MT1,7$")),
    ],
)
def test_the_newest_word_for_a_thruster_or_servo_replaces_the_one_that_waits(said, leaves) -> None:
    assert of(*said) == list(leaves)


@pytest.mark.parametrize(
    ("said", "leaves"),
    [
        ((b"@DA1,2$", b"@DA1,2$"), (b"@DA1,2$", b"@DA1,2$")),
        ((b"@DS1,9$", b"@DA1,2$", b"@DS1,5$"), (b"@DA1,2$", b"@DS1,5$")),
        ((b"@DA1,2$", b"@DS1,5$", b"@DA1,3$"), (b"@DA1,2$", b"@DS1,5$", b"@DA1,3$")),
        ((b"@MDA3,2$", b"@MDS1,5$"), (b"@MDA3,2$", b"@MDS1,5$")),
    ],
)
def test_an_increment_is_replaced_by_nothing_and_keeps_its_place(said, leaves) -> None:
    assert of(*said) == list(leaves)


def test_more_increments_than_the_line_takes_soon_are_refused_and_no_other_word_is() -> None:
    relays = Relays()
    told = add(relays, *[b"@DA1,1$"] * (INCREMENTS + 2), b"@DS1,5$", b"@MDA2,1$")
    assert [bool(why) for why in told] == [False] * INCREMENTS + [True, True, False, True]
    assert "set the angle" in told[-1]
    relays.take()
    assert add(relays, b"@DA1,1$") == [""]
    relays.clear()
    assert len(relays) == 0
    assert INCREMENTS * (len(b"@MDA3,-37$") * 10 / 9600 + 0.02) < 0.3  # s: what a stick waits


def test_the_stick_goes_before_rudders_and_power() -> None:
    said = (b"@RI$", b"@DS1,5$", b"@MMF5$", b"@MDS2,3$")
    assert of(*said) == [b"@MMF5$", b"@MDS2,3$", b"@RI$", b"@DS1,5$"]


def test_for_one_servo_the_order_is_kept_whoever_moves_it() -> None:
    assert of(b"@DA1,5$", b"@MMF5$", b"@MDS1,3$") == [b"@MMF5$", b"@DA1,5$", b"@MDS1,3$"]
    assert of(b"@MDS1,3$", b"@DS1,5$") == [b"@MDS1,3$", b"@DS1,5$"]


_gear, _angle = st.integers(-12, 12), st.integers(-15, 22)
WORDS = st.one_of(
    st.builds(lambda n, g: b"@MT%d,%d$" % (n, g), st.integers(1, 5), _gear),
    st.builds(lambda w, g: b"@MM%c%d$" % (w, abs(g)), st.sampled_from(b"FBUD"), _gear),
    st.builds(lambda w, g: b"@MR%c%d$" % (w, abs(g) % 6), st.sampled_from(b"LRFBUD"), _gear),
    st.builds(lambda w, a: b"@M%c120,%d$" % (w, a), st.sampled_from(b"SP"), _angle),
    st.builds(
        lambda m, a, n, v: m + b"%c%d,%d$" % (a, n, v),
        *(st.sampled_from([b"@MD", b"@D"]), st.sampled_from(b"AS"), st.integers(1, 3), _angle),
    ),
    st.sampled_from([b"@RI$", b"@RSOOOOOOO$", b"@RSCCCCCCC$"]),
)


def board(frames: list[bytes]) -> dict[str, object]:
    """What thrusters, servos and power are after these, in the documents' words."""
    state: dict[str, object] = defaultdict(int)
    for frame in frames:
        text = frame.decode()
        if servo := re.fullmatch(r"@M?D([AS])(\d),(-?\d+)\$", text):
            for n in (1, 2) if servo[2] == "3" else (int(servo[2]),):
                before = state[f"servo {n}"] if servo[1] == "A" else 0
                state[f"servo {n}"] = before + int(servo[3])  # type: ignore[operator]
        elif thruster := re.fullmatch(r"@MT(\d),.*", text):
            state[f"thruster {thruster[1]}"] = text
        elif text.startswith("@M"):
            mains = text.startswith(("@MMF", "@MMB", "@MRL", "@MRR", "@MS"))
            for n in (1, 2) if mains else (3, 4, 5):
                state[f"thruster {n}"] = text
        elif text.startswith("@RS"):
            state["power"] = text
    return dict(state)


@pytest.mark.proof
@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(WORDS, st.integers(0, 2)), max_size=120))
def test_whatever_comes_however_fast_the_vehicle_ends_as_it_was_told(script) -> None:
    """Between any two words the line may take some. What was not refused ends as if all of it
    had left, and never do more wait than there are thrusters and servos."""
    relays, taken, sent = Relays(), [], []
    for frame, free in script:
        if not relays.add(frame, "relay", frame.startswith(b"@M")):
            taken.append(frame)
        assert len(relays) <= MOST
        sent += [relays.take()[0] for _ in range(min(free, len(relays)))]
    sent += left(relays)
    assert board(sent) == board(taken)
    increments = [f for f in taken if f.startswith((b"@DA", b"@MDA"))]
    assert sorted(increments) == sorted(f for f in sent if f.startswith((b"@DA", b"@MDA")))


@pytest.mark.proof
@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(WORDS, st.booleans()), min_size=60, max_size=120))
def test_no_thruster_or_servo_waits_for_ever_however_the_others_are_moved(script) -> None:
    """The line takes every fourth: within as many as can wait, a word for it has left."""
    relays, owed = Relays(), {}
    for at, (frame, _) in enumerate(script * 4):
        if not relays.add(frame, "relay", frame.startswith(b"@M")):
            for name in board([frame]):
                owed.setdefault(name, at)
        if at % 4 == 3:
            for name in board([relays.take()[0]]):
                owed.pop(name, None)
        manual = {n: t for n, t in owed.items() if n.startswith("thruster")}
        assert all(at - t <= 4 * MOST for t in manual.values())
