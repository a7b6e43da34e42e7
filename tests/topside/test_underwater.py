"""An operator above the water, a whole Pi below it, and a modem's channel between them."""

from __future__ import annotations

import pytest
from pool_mission import DIGEST, LINES

from links.acoustic import AcousticLink, Water, acoustic_pair
from links.base import Rx
from mission.model import Tx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore
from mission.topside.console import Talk
from mission.topside.orders import order
from mission.topside.underwater import (
    BIT_RATE,
    RANGE_M,
    BatchTalk,
    ModemAddress,
    Submerged,
    WrongAddress,
    modem_address,
)
from mission.topside.upload import NoAnswer, Refused, clear, start, status
from protocol.arq import TRIES, Acoustics
from protocol.messages import Order, Status, StoreReport
from protocol.modem import Sender, wrap

NEAR = Water(range_m=300.0, bit_rate=1000.0)


class Sea:
    """The Pi answers on its modem link only; nothing else is connected to it."""

    def __init__(self, water: Water = NEAR, seed: int = 1) -> None:
        self.water = water
        self.store = MemoryStore()
        self.runtime = Runtime(Configuration(), load_vehicle("auv"), self.store)
        self.boat, self.diver = acoustic_pair(water, seed, ("boat", "modem"))
        self.now = 0.0

    @property
    def acoustics(self) -> Acoustics:
        return Acoustics(self.water.range_m, self.water.bit_rate)

    def hold(self, talk: Talk) -> Talk:
        _send(self.boat, talk.begin(self.now), self.now)
        while not talk.over:
            self.now = self._due(talk)
            for rx in self.diver.receive(self.now):
                self._pi(self.runtime.receive(Rx(rx.t, "modem", rx.data), self.now))
            due = self.runtime.next_timer()
            if due is not None and due <= self.now:
                self._pi(self.runtime.handle_timer(self.now))
            for rx in self.boat.receive(self.now):
                _send(self.boat, talk.receive(rx.data, self.now), self.now)
            due = talk.next_timer()
            if due is not None and due <= self.now and not talk.over:
                _send(self.boat, talk.handle_timer(self.now), self.now)
        return talk

    def _due(self, talk: Talk) -> float:
        timers = (
            *(self.boat.next_event(), self.diver.next_event()),
            *(talk.next_timer(), self.runtime.next_timer()),
        )
        return max(self.now, min(t for t in timers if t is not None))

    def _pi(self, out: list[Tx]) -> None:
        frames = [tx.data for tx in out if tx.link == "modem"]
        _send(self.diver, frames, self.now)

    def upload(self, lines: list[str] = LINES, of: str = DIGEST) -> Talk:
        self.told: list[int] = []
        talk = BatchTalk(lines, of, self.acoustics, lambda have, total: self.told.append(have))
        return self.hold(talk)


def _send(link: AcousticLink, frames: list[bytes], now: float) -> None:
    for frame in frames:
        link.send(frame, now)


def test_a_mission_goes_down_in_one_burst_and_its_digest_comes_up_in_one() -> None:
    sea = Sea()
    talk = sea.upload()
    assert talk.failure is None
    assert talk.result == f"{len(LINES)} lines stored, digest {DIGEST[:16]}"
    assert sea.store.content.lines == tuple(LINES)
    assert (sea.boat.tally.bursts, sea.diver.tally.bursts) == (1, 1)
    assert sea.told == [len(LINES)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("errors", [0.0, 1e-4])
def test_whatever_the_water_loses_the_pi_ends_with_the_mission(seed: int, errors: float) -> None:
    sea = Sea(Water(range_m=1000.0, bit_rate=600.0, loss=0.4, bit_error_rate=errors), seed)
    assert sea.upload().failure is None
    assert sea.store.content.lines == tuple(LINES)


def test_a_mission_that_the_pi_refuses_is_told_with_its_reason() -> None:
    lines = [*LINES[:-1], "up: goto nowhere"]
    talk = Sea().upload(lines, "0" * 16)
    assert isinstance(talk.failure, Refused)
    assert talk.result is None


def test_empty_water_is_no_answer_and_nothing_is_assumed() -> None:
    talk = Sea(Water(loss=1.0)).upload()
    assert isinstance(talk.failure, NoAnswer)
    assert "not known" in str(talk.failure)


def test_status_comes_up_through_the_water() -> None:
    sea, told = Sea(), []
    sea.upload()

    def took(said: Status, store: StoreReport | None) -> None:
        told.append((said, store))

    talk = sea.hold(Submerged(status(took), sea.acoustics))
    assert talk.failure is None
    ((_, store),) = told
    assert store is not None
    assert (store.state, store.digest) == ("ready", DIGEST[:16])


def test_a_refused_start_says_why_and_clear_clears() -> None:
    sea = Sea()
    sea.upload()
    talk = sea.hold(Submerged(start(), sea.acoustics))  # no navigation, no fix
    assert isinstance(talk.failure, Refused)
    assert sea.hold(Submerged(clear(), sea.acoustics)).result == "cleared"
    assert sea.store.content.lines == ()


def test_silence_is_said_after_two_tries_but_an_order_goes_on() -> None:
    sea = Sea(Water(loss=1.0))
    talk = sea.hold(Submerged(start(), sea.acoustics))
    assert isinstance(talk.failure, NoAnswer)
    assert sea.boat.tally.bursts == TRIES
    talk = sea.hold(Submerged(order(Order.SURFACE), sea.acoustics))
    assert isinstance(talk.failure, NoAnswer)
    assert sea.boat.tally.bursts > TRIES + 5


def test_a_clear_that_is_said_twice_is_the_operators_wish_so_it_is_tried_once() -> None:
    sea = Sea(Water(loss=1.0))
    talk = sea.hold(Submerged(clear(), sea.acoustics))
    assert isinstance(talk.failure, NoAnswer)
    assert sea.boat.tally.bursts == 1


def test_what_was_not_asked_for_answers_nothing() -> None:
    talk = Submerged(status(lambda said, store: None), Acoustics(300.0, 1000.0))
    talk.begin(0.0)
    for stray in (b"@ACK_AAA$", b"@AR,nonsense,$"):
        assert talk.receive(wrap(stray, Sender.VEHICLE), 1.0) == []
    assert not talk.over


def test_a_modems_url_is_its_links_with_range_and_rate() -> None:
    assert modem_address("tcp://host:1") is None
    found = modem_address("modem+serial:///dev/ttyUSB0?baud=115200&range=800&rate=600")
    link = "serial:///dev/ttyUSB0?baud=115200"
    assert found == ModemAddress(link, Acoustics(800.0, 600.0))
    assert modem_address("modem+serial:///dev/ttyUSB0?range=800&rate=600") == found
    plain = modem_address("modem+tcp://10.0.0.7:9000")
    assert plain == ModemAddress("tcp://10.0.0.7:9000", Acoustics(RANGE_M, BIT_RATE))
    slow = modem_address("modem+serial:///dev/ttyUSB0?baud=1200&range=800&rate=600")
    assert slow is not None
    assert slow.acoustics == Acoustics(800.0, 600.0, baud=1200)


@pytest.mark.parametrize("option", ["range=far", "rate=0", "rate=-5", "range=nan"])
def test_a_wrong_range_or_rate_is_refused(option: str) -> None:
    with pytest.raises(WrongAddress, match=r"a number of (m|bit/s) above 0"):
        modem_address(f"modem+tcp://10.0.0.7:9000?{option}")
