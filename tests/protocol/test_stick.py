"""What the stick of document 000 becomes in the frames of the other vehicles, word by word."""

from __future__ import annotations

import pytest

from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import Setpoint
from protocol.vehicles import VEHICLES, codec, link
from protocol.vehicles.adapter import SilentBoard

SILENT = [row.name for row in VEHICLES.values() if row.name != "auv"]
LIKE = {"mainboard": "motorcan"}  # the same motor boards, and a sensor board beside them
DOWN = {
    "coreboard": "coreboard.pc_to_main",
    "motorcan": "coreboard.can",
    "rov": "rov.down",
    "robot": "robot.down",
}
NOTHING = {
    "coreboard": dict.fromkeys(("tx", "ty", "tz", "mx", "my", "mz", "closed_loop"), 0),
    "motorcan": dict.fromkeys(("fx_g", "fy_g", "fz_g", "mx_nm", "my_nm", "mz_nm"), 0),
    "rov": {"x": 0.0, "z": 0.0, "f": 0.0, "hold_heading": 0, "hold_depth": 0},
    "robot": {"command": 0},
}
HAS: dict[bytes, dict[str, dict[str, float]]] = {
    b"@MMF6$": {
        "coreboard": {"tx": 50},
        "motorcan": {"fx_g": 2500},
        "rov": {"x": 0.5},
        "robot": {"command": 1, "speed_mm_s": 500},
    },
    b"@MMB12$": {
        "coreboard": {"tx": -100},
        "motorcan": {"fx_g": -5000},
        "rov": {"x": -1.0},
        "robot": {"command": 2, "speed_mm_s": 1000},
    },
    b"@MRL5$": {
        "coreboard": {"mz": -100},
        "motorcan": {"mz_nm": -20},
        "rov": {"z": -1.0},
        "robot": {"command": 10, "speed_mm_s": 1000},
    },
    b"@MRR2$": {
        "coreboard": {"mz": 40},
        "motorcan": {"mz_nm": 8},
        "rov": {"z": pytest.approx(0.4)},
        "robot": {"command": 9, "speed_mm_s": 400},
    },
    b"@MMU3$": {"coreboard": {"tz": -25}, "motorcan": {"fz_g": -1250}, "rov": {"f": 0.25}},
    b"@MMD12$": {"coreboard": {"tz": 100}, "motorcan": {"fz_g": 5000}, "rov": {"f": -1.0}},
    b"@MMF0$": {"coreboard": {}, "motorcan": {}, "rov": {}, "robot": {}},
    b"@MMF-0$": {"coreboard": {}, "motorcan": {}, "rov": {}, "robot": {}},
    b"@MRL-00$": {"coreboard": {}, "motorcan": {}, "rov": {}, "robot": {}},
}
NONE = [
    *(b"@MT1,-10$", b"@MDA2,-2$", b"@MDS3,20$", b"@MS120,-90$", b"@MP120,-90$"),
    *(b"@MRB3$", b"@MRF3$", b"@MRU3$", b"@MRD0$"),
    *(b"@RSCOOCCCO$", b"@RI$", b"@DA2,-2$", b"@DS3,20$"),
]


def board(name: str, **wire: str) -> SilentBoard:
    one = codec(name, "documented", {}, wire=wire)
    assert isinstance(one, SilentBoard)
    return one


def moved(name: str, setpoint: Setpoint, **wire: str) -> dict[str, float]:
    """What of its frames moves it, as the board reads them."""
    found: dict[str, float] = {}
    like = LIKE.get(name, name)
    for raw in board(name, **wire).encode(setpoint):
        for frame in link(DOWN[like]).framer().receive(raw, 0.0):
            found |= frame.values() if isinstance(frame, Frame) else {}
    names = {*NOTHING[like], "speed_mm_s"}
    return {key: value for key, value in found.items() if key in names}


@pytest.mark.parametrize("name", SILENT)
@pytest.mark.parametrize("word", HAS)
def test_each_word_is_an_effort_in_the_vehicles_own_frames_or_refused(
    name: str, word: bytes
) -> None:
    like = LIKE.get(name, name)
    wanted = HAS[word].get(like)
    if wanted is None:
        with pytest.raises(CannotEncode, match=r"this vehicle has no @MM[UD]: no heave"):
            board(name).stick(Setpoint(), word)
    else:
        assert moved(name, board(name).stick(Setpoint(), word)) == NOTHING[like] | wanted


@pytest.mark.parametrize("name", SILENT)
@pytest.mark.parametrize("word", NONE)
def test_what_the_documents_of_these_vehicles_have_no_frame_for_is_refused_with_its_name(
    name: str, word: bytes
) -> None:
    with pytest.raises(CannotEncode, match=r"this vehicle has no (@M|R and no D)"):
        board(name).stick(Setpoint(), word)


@pytest.mark.parametrize("name", ["coreboard", "motorcan", "mainboard", "rov"])
def test_up_and_down_go_on_under_the_words_ahead_and_a_turn_ends_the_way_on(name: str) -> None:
    """As the AUV has them: mains by one kind of word, verticals by the other."""
    stick = board(name).stick
    held = stick(stick(Setpoint(), b"@MMD6$"), b"@MMF6$")
    assert (held.surge, held.turn, held.heave) == (0.5, 0.0, 0.5)
    held = stick(held, b"@MRR5$")
    assert (held.surge, held.turn, held.heave) == (0.0, 1.0, 0.5)
    held = stick(stick(held, b"@MMF0$"), b"@MMU0$")
    assert (held.surge, held.turn, held.heave) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", SILENT)
@pytest.mark.parametrize("axis", ["surge", "turn", "heave"])
def test_the_vehicle_file_says_what_share_of_the_effort_a_stick_has(name: str, axis: str) -> None:
    if name == "robot" and axis == "heave":
        return
    word = {"surge": b"@MMF12$", "turn": b"@MRR5$", "heave": b"@MMD12$"}[axis]
    held = board(name, **{f"stick_{axis}": "0.25"}).stick(Setpoint(), word)
    assert getattr(held, axis) == 0.25
