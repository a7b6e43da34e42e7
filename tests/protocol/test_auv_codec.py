"""The AUV's adapter: units and signs in, and complete sets out from whatever went before."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from canonical_auv import SD as CANONICAL
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.checksum import crc32_stm32
from protocol.codec import CannotEncode
from protocol.messages import Ack, FrameFault, Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles import auv, codec
from protocol.vehicles.auv import SD, AuvCodec, sd_frame, shortcut, telemetry


def values(**changes: float | None) -> dict[str, object]:
    return SD.decode(CANONICAL) | changes


def one(**changes: float | None) -> Telemetry:
    (message,) = AuvCodec().receive(SD.pack(values(**changes)), 3.0)
    assert isinstance(message, Telemetry)
    return message


# --- Telemetry in ---


@pytest.mark.parametrize(
    ("yaw", "heading"), [(0, 0), (-90, 90), (90, 270), (180, 180), (-180, 180), (-45, 45)]
)
def test_yaw_is_positive_to_port_and_heading_to_starboard(yaw: float, heading: float) -> None:
    assert one(yaw_deg=yaw).heading == pytest.approx(math.radians(heading))


def test_units_become_si() -> None:
    message = one(
        roll_deg=30, pitch_deg=-45, temperature_c=12.5, depth_m=7.25, altitude_m=3.5,
        mag_front_x=50, mag_right_z=-100, pwm_left_main=2000, pwm_servo_right=1250,
        battery_control=12, battery_power=48,
    )  # fmt: skip
    assert message.roll == pytest.approx(math.pi / 6)
    assert message.pitch == pytest.approx(-math.pi / 4)
    assert (message.t, message.temperature_c, message.depth, message.altitude) == (
        3,
        12.5,
        7.25,
        3.5,
    )
    assert message.magnetic is not None
    assert (message.magnetic[0], message.magnetic[8]) == pytest.approx((50e-6, -100e-6))
    assert message.actuators == (1, 0, 0, 0, 0, 0, -0.5)
    assert message.batteries == (12, 48)
    assert message.faults == ()


def test_batteries_are_volts_by_the_vehicles_own_factor() -> None:
    made = codec("auv", "as-built", {}, (0.1, 0.2))
    (message,) = made.receive(SD.encode(values(battery_control=120, battery_power=240)), 0.0)
    assert isinstance(message, Telemetry)
    assert message.batteries == pytest.approx((12, 48))


@pytest.mark.parametrize(
    ("field", "wire", "fault"),
    [
        ("depth", "depth_m", "nan"),
        ("altitude", "altitude_m", "inf"),
        ("heading", "yaw_deg", "nan"),
        ("pitch", "pitch_deg", "inf"),
        ("roll", "roll_deg", "nan"),
        ("temperature_c", "temperature_c", "nan"),
        ("magnetic", "mag_left_y", "nan"),
    ],
)
def test_what_is_no_number_is_not_reported_and_named(field: str, wire: str, fault: str) -> None:
    message = one(**{wire: math.nan if fault == "nan" else -math.inf})
    assert getattr(message, field) is None
    assert message.faults == (f"{wire}:{fault}",)
    others = {"depth", "heading", "roll"} - {field}
    assert all(getattr(message, other) is not None for other in others)


@pytest.mark.parametrize(
    ("wire", "value"),
    [
        ("roll_deg", 91),
        ("pitch_deg", -181),
        ("yaw_deg", 200),
        ("mag_front_z", 101),
        ("mag_left_x", -300),
    ],
)
def test_what_is_out_of_range_is_kept_and_named(wire: str, value: float) -> None:
    message = one(**{wire: value})
    assert message.faults == (f"{wire}:out_of_range",)
    assert message.depth == 0


@pytest.mark.parametrize(
    ("wire", "width", "told"),
    [
        ("pwm_rear_vert", 2100, (0, 0, 1.2, 0, 0, 0, 0)),
        ("pwm_left_main", 900, (-1.2, 0, 0, 0, 0, 0, 0)),
        ("pwm_left_main", 0, (0,) * 7),  # no pulse
        ("pwm_servo_right", 0, (0,) * 7),
        ("pwm_servo_right", 2500, (0, 0, 0, 0, 0, 0, 2)),  # a servo's may be wider
        ("pwm_rear_vert", 2101, None),
        ("pwm_left_main", 899, None),
        ("pwm_right_vert", 1, None),
        ("pwm_rear_vert", 65535, None),
    ],
)
def test_a_width_that_is_no_pwm_tells_nothing_of_the_thrusters(
    wire: str, width: int, told: tuple[float, ...] | None
) -> None:
    message = one(**{wire: width})
    assert message.actuators == told
    assert message == telemetry(SD.pack(values(**{wire: width})), 3.0)
    assert message.faults == ()


def test_a_width_that_is_no_pwm_hides_no_thruster_that_is_on() -> None:
    """Behind a stop they would run on, and nobody would stop them again (R7)."""
    running = {"pwm_left_main": 2000, "pwm_right_main": 2000, "pwm_rear_vert": 3000}
    assert one(**running).actuators == (1, 1, 0, 0, 0, 0, 0)
    assert one(**running) == telemetry(SD.pack(values(**running)), 3.0)
    assert one(pwm_left_main=1510, pwm_rear_vert=3000).actuators is None


finite = st.floats(-400, 400, width=32)


@pytest.mark.proof
@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.one_of(finite, st.floats(width=32)), min_size=15, max_size=15),
    st.lists(
        st.one_of(st.integers(0, 65535), st.integers(800, 2200), st.just(0)),
        min_size=9,
        max_size=9,
    ),
)
def test_the_shortcut_says_what_the_table_says_or_nothing(
    floats: list[float], words: list[int]
) -> None:
    names = [name for name in SD.decode(CANONICAL) if name != "flags"]
    raw = SD.pack(dict(zip(names, [*floats, *words], strict=True)))
    scale = (0.5, 2.0)
    quick, gaps, stop = shortcut(Tolerances(), scale).read(raw, 0, 0, 0, 1.0)
    slow = telemetry(raw, 1.0, scale)
    assert (list(quick), gaps, stop) in (([slow], 0, 86), ([], 0, 0))
    pulses = all(w == 0 or 900 <= w <= 2100 for w in words[:5])  # others are left to the table
    if slow.faults:
        assert not quick
    elif pulses and max(words[:7]) < 2500 and max(map(abs, floats[6:])) < 57:
        assert type(quick[0]) is Telemetry


def test_the_shortcut_reads_on_over_noise_in_which_no_frame_could_begin() -> None:
    read = shortcut(Tolerances(), (1.0, 1.0)).read
    data = CANONICAL + CANONICAL + b"noise" + CANONICAL + b"n@ise" + CANONICAL
    last = len(data) - 86
    items, gaps, stop = read(data, 0, last, 1000, 2.0)
    message = telemetry(CANONICAL, 2.0)
    assert items == [message, message, FrameFault(1172, "bad_header", 5), message]
    assert (gaps, stop) == (1, 3 * 86 + 5)
    assert read(data, 86, 86, 0, 2.0) == ([message], 0, 172)
    assert read(data, 1, last, 0, 2.0) == ([], 0, 1)
    assert read(CANONICAL + b"end" + bytes(83), 0, 86, 0, 2.0) == ([message], 0, 86)


def test_the_shortcut_takes_no_frame_whose_head_tail_or_checksum_is_wrong() -> None:
    read = shortcut(Tolerances(), (1.0, 1.0)).read
    for at in range(86):
        broken = bytearray(CANONICAL)
        broken[at] ^= 0x80
        assert read(bytes(broken), 0, 0, 0, 0.0) == ([], 0, 0)


def test_another_checksum_goes_the_ordinary_way() -> None:
    chosen = Tolerances({"sd_crc": "bytes/data"})
    raw = sd_frame(chosen).encode(SD.decode(CANONICAL))
    assert AuvCodec("as-built", chosen).receive(raw, 3.0) == [telemetry(CANONICAL, 3.0)]
    assert shortcut(chosen, (1.0, 1.0)).read(raw, 0, 0, 0, 3.0) == ((), 0, 0)


def test_the_shortcuts_telemetry_is_frozen_like_any_other() -> None:
    message = one()
    with pytest.raises(AttributeError):
        message.depth = 1.0  # type: ignore[misc]
    assert message._replace(depth=1.0).depth == 1.0
    assert hash(message) == hash(Telemetry(**message._asdict()))


def test_acknowledgements_and_faults_come_in_order() -> None:
    made = AuvCodec()
    items = made.receive(b"..@ACK_ZAN$" + CANONICAL[:30] + b"@ACK_RI\x11$" + CANONICAL[30:], 2.0)
    assert [type(i) for i in items] == [FrameFault, Ack, Telemetry, Ack]
    refused, mask = items[1], items[3]
    assert isinstance(refused, Ack)
    assert isinstance(mask, Ack)
    assert (refused.group, refused.function, refused.ok, refused.t) == ("Z", "A", False, 2.0)
    assert (mask.group, mask.function, mask.result) == ("R", "I", 0x11)


def test_a_cut_frame_is_given_up_by_the_timer() -> None:
    made = AuvCodec()
    assert made.receive(CANONICAL[:9] + b"@ACK_ZFY$", 5.0) == []
    due = made.next_timer()
    assert due == pytest.approx(5.05)
    assert [type(i) for i in made.flush(5.1)] == [FrameFault, Ack]
    assert made.next_timer() is None


def test_another_crc_profile_is_a_tolerance() -> None:
    raw = bytearray(CANONICAL)
    raw[81:85] = crc32_stm32(bytes(raw[:81])).to_bytes(4, "little")
    assert isinstance(AuvCodec().receive(bytes(raw), 0.0), list)
    (message,) = codec("auv", "as-built", {"sd_crc": "words/frame"}).receive(bytes(raw), 0.0)
    assert isinstance(message, Telemetry)
    assert not any(isinstance(i, Telemetry) for i in AuvCodec().receive(bytes(raw), 0.0))


# --- Setpoint out: the STM32 as built, in its own words ---


class AsBuilt:
    """One horizontal mode, one vertical mode, one speed; X0 clears both modes."""

    def __init__(self) -> None:
        self.horizontal, self.vertical, self.speed = "", "", 0
        self.heading = self.target = 0

    def hear(self, frame: bytes) -> None:
        code, text = chr(frame[3]), frame[4:-1].decode()
        if code == "X":
            self.horizontal, self.vertical, self.speed = "", "", 0
        elif code in "FBLR":
            self.horizontal, self.speed = code, int(text)
        elif code in "UD":
            self.vertical, self.speed = code, int(text)
        elif code in "SE":
            self.vertical, self.target = code, int(text)
        elif code == "H":
            heading, _, speed = text.partition(",")
            self.horizontal, self.heading, self.speed = "H", int(heading), int(speed or 0)
        assert code in "XFBLRUDSEH"

    def acts(self) -> tuple[object, ...]:
        across = (self.horizontal, self.heading if self.horizontal == "H" else 0)
        moving = self.speed if self.horizontal or self.vertical in ("U", "D") else 0
        deep = (self.vertical, self.target if self.vertical in ("S", "E") else 0)
        return (*across, *deep, moving)


class Documented:
    """Every word its own axis; X0 clears them all."""

    def __init__(self) -> None:
        self.axes: dict[str, str] = {}

    def hear(self, frame: bytes) -> None:
        code, text = chr(frame[3]), frame[4:-1].decode()
        axis = {"F": "x", "B": "x", "L": "n", "R": "n", "H": "h", "A": "a"}.get(code, "z")
        if code == "X":
            self.axes = {}
        elif code in "FBLRUD" and text == "0":
            self.axes.pop(axis, None)
        else:
            self.axes[axis] = code + text

    def acts(self) -> tuple[object, ...]:
        return tuple(sorted(self.axes.items()))


gear = st.integers(-12, 12).map(lambda g: g / 12)
ahead = st.integers(0, 12).map(lambda g: g / 12)
metres, angle = st.floats(0, 90), st.floats(-1, 1)
ACROSS = st.one_of(
    st.just({}),
    st.fixed_dictionaries({"surge": gear}),
    st.fixed_dictionaries({"turn": gear}),
    st.fixed_dictionaries({"surge": ahead, "heading": st.floats(0, 6.28)}),
)
DEEP = st.one_of(
    st.just({}),
    st.fixed_dictionaries({"depth": metres}),
    st.fixed_dictionaries({"altitude": metres}),
    st.fixed_dictionaries({"heave": gear}),
)
LEVEL = st.one_of(st.just({}), st.fixed_dictionaries({"pitch": angle, "roll": angle}))


def setpoints(dialect: str) -> st.SearchStrategy[Setpoint]:
    level = LEVEL if dialect == "documented" else st.just({})
    return st.builds(
        lambda *parts: Setpoint(**{k: v for p in parts for k, v in p.items()}), ACROSS, DEEP, level
    )


def encodable(dialect: str, setpoint: Setpoint) -> list[bytes] | None:
    try:
        return AuvCodec(dialect).encode(setpoint)
    except CannotEncode:
        return None


@pytest.mark.proof
@pytest.mark.parametrize(("dialect", "stm32"), [("as-built", AsBuilt), ("documented", Documented)])
@settings(max_examples=150, deadline=None)
@given(data=st.data(), rng=st.randoms(use_true_random=False))
def test_a_setpoint_is_reached_from_any_earlier_state(
    dialect: str,
    stm32: type[AsBuilt] | type[Documented],
    data: st.DataObject,
    rng: random.Random,
) -> None:
    """Leftovers, and sets that were cut short by a lost word, change nothing."""
    before = data.draw(st.lists(setpoints(dialect), max_size=6))
    used, last = stm32(), None
    for setpoint in before:
        frames = encodable(dialect, setpoint)
        if frames is None:
            continue
        for frame in frames[: rng.randint(0, len(frames))]:
            used.hear(frame)
        last = frames
    if last is None:
        return
    fresh = stm32()
    for frame in last:
        used.hear(frame)
        fresh.hear(frame)
    assert used.acts() == fresh.acts()


@pytest.mark.proof
@pytest.mark.parametrize(("dialect", "stm32"), [("as-built", AsBuilt), ("documented", Documented)])
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_change_leads_where_the_whole_set_does_and_stops_nothing_on_its_way(
    dialect: str, stm32: type[AsBuilt] | type[Documented], data: st.DataObject
) -> None:
    """Also where the board has forgotten what it held."""
    one, other = data.draw(setpoints(dialect)), data.draw(setpoints(dialect))
    turned = one if one.heading is None else replace(one, heading=data.draw(st.floats(0, 6.28)))
    for wanted in (other, turned):
        held, whole = encodable(dialect, one), encodable(dialect, wanted)
        if held is None or whole is None:
            continue
        frames = auv.change(whole, held)
        assert frames
        for before in (held, []):
            used, fresh = stm32(), stm32()
            for frame in (*before, *frames):
                used.hear(frame)
            for frame in whole:
                fresh.hear(frame)
            assert used.acts() == fresh.acts()
        if wanted is turned and len(whole) > 1:
            assert b"@ZAX0$" not in frames


@pytest.mark.parametrize(
    ("setpoint", "words"),
    [
        (Setpoint(), ["X0"]),
        (Setpoint(surge=0.5), ["X0", "F6"]),
        (Setpoint(surge=-0.5), ["X0", "B6"]),
        (Setpoint(turn=0.25), ["X0", "R3"]),
        (Setpoint(turn=-0.25), ["X0", "L3"]),
        (Setpoint(heave=-1.0), ["X0", "U12"]),
        (Setpoint(heave=1.0), ["X0", "D12"]),
        (Setpoint(heave=0.0), ["X0"]),
        (Setpoint(surge=0.5, heave=0.5), ["D6", "F6"]),
        (Setpoint(surge=0.5, heave=-0.5, heading=0.0), ["U6", "H0,6"]),
        (Setpoint(depth=10.4), ["X0", "S10"]),
        (Setpoint(surge=0.5, depth=10.0, heading=math.pi / 2), ["S10", "H-90,6"]),
        (Setpoint(surge=1 / 3, altitude=3.0), ["E3", "F4"]),
        (Setpoint(depth=3.0, heading=math.radians(270)), ["S3", "H90,0"]),
        (Setpoint(heading=math.pi), ["X0", "H-180,0"]),
        (Setpoint(surge=0.03), ["X0"]),
    ],
)
def test_as_built_words(setpoint: Setpoint, words: list[str]) -> None:
    sent = [f[3:-1].decode() for f in AuvCodec("as-built").encode(setpoint)]
    assert sent == words


@pytest.mark.parametrize(
    ("setpoint", "words"),
    [
        (Setpoint(), ["X0"]),
        (Setpoint(surge=0.5, turn=-0.25, heave=0.75), ["X0", "F6", "L3", "D9"]),
        (Setpoint(surge=0.5, depth=10.0, heading=math.pi / 2), ["X0", "F6", "H-90", "S10"]),
        (
            Setpoint(surge=0.5, depth=0.0, heading=0.0, pitch=0.1, roll=-0.1),
            ["F6", "R0", "H0", "S0", "A6;-6"],
        ),
        (Setpoint(roll=math.radians(5)), ["X0", "A0;5"]),
        (Setpoint(altitude=3.0), ["X0", "E3"]),
    ],
)
def test_documented_words(setpoint: Setpoint, words: list[str]) -> None:
    sent = AuvCodec("documented").encode(setpoint)
    assert [frame[3:-1].decode() for frame in sent] == words


@pytest.mark.parametrize("dialect", auv.DIALECTS)
def test_the_two_orders_are_one_word_each(dialect: str) -> None:
    made = AuvCodec(dialect)
    assert made.encode(Order.STOP) == [b"@ZAX0$"]
    assert made.encode(Order.SURFACE) == [b"@ZAWF$"]


@pytest.mark.parametrize(
    ("dialect", "setpoint", "message"),
    [
        ("as-built", Setpoint(pitch=0.1), "pitch and roll"),
        ("as-built", Setpoint(surge=0.5, turn=0.5), "one horizontal mode"),
        ("as-built", Setpoint(heading=1.0, turn=0.5), "turn: the heading"),
        ("as-built", Setpoint(heading=1.0, surge=-0.5), "astern"),
        ("as-built", Setpoint(surge=0.5, heave=1.0), "share one speed"),
        ("as-built", Setpoint(heading=0.0, heave=-1.0), "share one speed"),
        ("documented", Setpoint(heading=1.0, turn=0.5), "turn: the heading"),
        ("documented", Setpoint(roll=2.0), "outside"),
        ("documented", Setpoint(pitch=math.nan), "outside"),
        ("as-built", Setpoint(surge=1.1), "outside -1..1"),
        ("as-built", Setpoint(surge=math.nan), "outside -1..1"),
        ("as-built", Setpoint(depth=-1.0), "outside 0..9999"),
        ("as-built", Setpoint(altitude=math.nan), "outside 0..9999"),
        ("as-built", Setpoint(heading=math.inf), "no angle"),
        ("as-built", Setpoint(depth=1.0, altitude=1.0), "at most one"),
    ],
)
def test_what_the_vehicle_cannot_follow_is_said(
    dialect: str, setpoint: Setpoint, message: str
) -> None:
    with pytest.raises(CannotEncode, match=message):
        AuvCodec(dialect).encode(setpoint)


def test_every_word_is_a_frame_of_its_own_that_fits_one_burst() -> None:
    frames = AuvCodec().encode(Setpoint(surge=0.5, depth=9999.0, heading=math.pi - 0.01))
    assert all(f.startswith(b"@ZA") and f.endswith(b"$") and len(f) < 99 for f in frames)


def test_an_unknown_dialect_says_which_there_are() -> None:
    with pytest.raises(ValueError, match="as-built"):
        AuvCodec("nothing")


def test_a_report_behind_a_false_start_has_the_time_of_its_own_first_byte() -> None:
    """The false start kept it waiting; it came with the first chunk all the same."""
    codec = AuvCodec("documented")
    false = SD.lead + b"\x01" * 17
    for begun in (0.0, 100.0):  # nothing before it in the stream, and something
        heard = codec.receive(false + CANONICAL[:30], begun + 1.0)
        heard += codec.receive(CANONICAL[30:] + CANONICAL, begun + 2.0)
        assert [m.t for m in heard if isinstance(m, Telemetry)] == [begun + 1.0, begun + 2.0]
