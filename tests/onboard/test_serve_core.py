"""Two boats, links that lose, double, garble and cut, a board that fails, a program that is killed
and a disk that fills, in any order: what serve promises about missions and states holds.

    no lost, doubled or mixed line    the store holds nothing, or exactly a mission that was sent
    an accepted mission stays         until it is cleared, or another one is accepted whole
    digests are equal on both sides   whenever an upload says that it is done, and over restarts
    no unknown state                  a leaf of the regions, or a leg of the loaded chart
    no byte without a reason          the audit of the fault campaign, and 20 ms between frames
    a way back from everywhere        when all is mended: surface, clear, upload, start
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from core_world import MISSIONS, Boat, CoreWorld, Known
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from links.simulated.faults import FAULTS
from mission.authoring.language import digest, parse_script
from mission.model import SURFACED, Tx
from mission.model.regions import REGIONS
from mission.onboard.runtime.runtime import VEHICLE
from mission.topside.orders import order
from mission.topside.upload import Conversation, Refused, clear, start, upload
from mission.verification.campaign.audit import audit
from mission.verification.rig.line import crowded
from mission.verification.rig.program import Death
from protocol.messages import MissionLine, Order
from protocol.topside import encode

LEAVES = {leaf for leaves in REGIONS.values() for leaf in leaves}
BOATS = st.sampled_from([0, 0, 0, 1])
KNOWN = st.sampled_from(MISSIONS)
SHARES = st.sampled_from([0.0, 0.0, 0.1, 0.3])
BOARD = ("stm32_silent", "ack_lost", "command_lost", "bytes_corrupted", "line_noise", "splice",
         "stm32_restart", "gps_silent", "depth_frozen")  # fmt: skip
WORDS = (b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@AC$", b"@AC$", b"@MMF5$", b"@MMF0$", b"@DU$", b"@AQ$",
         b"@NSOOOCCC$", b"@NSOOOCCO$", b"@SP,300,15,9,10,$", b"@RI$")  # fmt: skip
PATIENCE = 400.0  # s


def quiet(have: int, total: int) -> None:
    """Nobody watches."""


@settings(
    max_examples=30,
    stateful_step_count=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
class ServeCore(RuleBasedStateMachine):
    world: CoreWorld

    @initialize(profile=st.sampled_from(["as-built", "documented"]), seed=st.integers(0, 99))
    def begin(self, profile: str, seed: int) -> None:
        self.world = CoreWorld(profile, seed)
        self.failed: set[str] = set()
        self.before: tuple[str, ...] = ()
        self.do(lambda: self.world.run(6.0))

    def do(self, work: Callable[[], object]) -> None:
        """One thing, and what must hold when it is done."""
        self.world.delivered = b""
        work()
        self.look_at_the_store()
        for boat in self.world.boats:
            self.look_at(boat)

    def boat(self, number: int) -> Boat:
        boat = self.world.boats[number]
        if not self.world.is_connected(boat):
            self.do(lambda: self.world.connect(boat))
        return boat

    # --- what may happen ---------------------------------------------------------------------

    @rule(number=BOATS, known=KNOWN, seconds=st.floats(0.0, 5.0))
    def sends_a_mission(self, number: int, known: Known, seconds: float) -> None:
        boat = self.boat(number)
        if boat.talk is None or boat.talk.over:
            talk = upload(known.lines, known.digest, quiet)
            self.do(lambda: self.world.hold(boat, talk, known))
            self.do(lambda: self.world.run(seconds))

    @rule(number=BOATS, known=KNOWN, places=st.lists(st.integers(0, 9), min_size=1, max_size=12))
    def sends_lines_of_one(self, number: int, known: Known, places: list[int]) -> None:
        """In no order, some of them more than once."""
        boat, total = self.boat(number), len(known.lines)
        for place in places:
            line = encode(MissionLine(total, place % total + 1, known.lines[place % total]))
            self.do(lambda line=line: self.world.over_the_air(boat, [line]))

    @rule(number=BOATS)
    def is_cut_off(self, number: int) -> None:
        self.do(lambda: self.world.part(self.world.boats[number]))

    @rule(lost=SHARES, doubled=SHARES, garbled=SHARES, cut=SHARES)
    def links_get_other(self, lost: float, doubled: float, garbled: float, cut: float) -> None:
        faults = self.world.faults
        faults.lost, faults.doubled, faults.garbled, faults.cut = lost, doubled, garbled, cut

    @rule(number=BOATS, word=st.sampled_from(WORDS))
    def says(self, number: int, word: bytes) -> None:
        boat = self.boat(number)
        self.do(lambda: self.world.over_the_air(boat, [word]))

    @rule(number=BOATS)
    def starts(self, number: int) -> None:
        boat = self.boat(number)
        if boat.talk is None or boat.talk.over:
            self.do(lambda: self.world.hold(boat, start(patience=2)))
            self.do(lambda: self.world.run(4.0))

    @rule(known=KNOWN, full=st.booleans())
    def has_a_mission_and_clears_it(self, known: Known, full: bool) -> None:
        """Whole, or refused and then nothing of it."""
        boat, store = self.boat(0), self.world.store
        self.do(lambda: self.world.hold(boat, upload(known.lines, known.digest, quiet), known))
        self.do(lambda: self.world.run(2.5))
        if self.world.runtime is not None:
            store.full, before = full, (self.world.runtime.state, store.content.lines)
            held: list[Conversation] = []
            self.do(lambda: held.append(self.world.hold(boat, clear())))
            talk = held[0]
            if isinstance(talk.failure, Refused) and self.world.runtime is not None:
                assert (self.world.runtime.state, store.content.lines) == before
            assert talk.result is None or store.content.lines == ()

    @rule(known=KNOWN, seconds=st.floats(0.0, 20.0))
    def flies(self, known: Known, seconds: float) -> None:
        """As it should be, where the links let it."""
        boat = self.boat(0)
        for talk, sends in (
            (upload(known.lines, known.digest, quiet), known),
            (start(patience=2), None),
        ):
            if boat.talk is None or boat.talk.over:
                self.do(lambda talk=talk, sends=sends: self.world.hold(boat, talk, sends))
                self.do(lambda: self.world.run(2.5))
        self.do(lambda: self.world.run(seconds))

    @rule(name=st.sampled_from(BOARD))
    def fails_or_is_mended(self, name: str) -> None:
        self.failed ^= {name}
        (self.world.fail if name in self.failed else self.world.mend)(name)

    @rule(what=st.sampled_from([True, False, *Death]))
    def disk(self, what: bool | Death) -> None:
        """Full, with room, or the place where the program dies."""
        if isinstance(what, Death):
            self.world.store.death = what
        else:
            self.world.store.full = what

    @rule()
    def is_killed(self) -> None:
        self.do(self.world.die)
        self.begins_anew()

    def begins_anew(self) -> None:
        """As the service manager does it, a second later."""
        if not self.world.program.lives:
            self.do(lambda: self.world.run(1.0))
            self.world.boot()

    @rule(seconds=st.floats(0.01, 20.0))
    def time(self, seconds: float) -> None:
        self.do(lambda: self.world.run(seconds))
        self.begins_anew()

    # --- what must hold ------------------------------------------------------------------------

    def look_at_the_store(self) -> None:
        lines, before = self.world.store.content.lines, self.before
        assert lines in ((), *(known.lines for known in MISSIONS)), "lost, doubled or mixed"
        if lines != before:
            said = self.world.delivered
            assert (b"@AC$" if not lines else b"@AW") in said, "lost, or there by itself"
        self.before = lines

    def look_at(self, boat: Boat) -> None:
        """An upload that is over has done what it says."""
        if boat.talk is None or not boat.talk.over:
            return
        if boat.sends is not None and boat.talk.result is not None:
            assert self.world.store.content.lines == boat.sends.lines
            assert self.world.runtime is None or self.world.runtime.digest == boat.sends.digest
        boat.talk, boat.sends = None, None

    @invariant()
    def the_state_is_one_of_the_design(self) -> None:
        if (runtime := self.world.runtime) is not None:
            chart = runtime.engine.chart
            known = {s.path for s in chart.states if s.leg} if chart else set()
            assert runtime.state in LEAVES | known

    @invariant()
    def what_is_stored_is_what_is_told(self) -> None:
        runtime, lines = self.world.runtime, self.world.store.content.lines
        if runtime is not None and not runtime.unjudged:  # after a restart: not before idle
            assert runtime.digest == (digest(parse_script(lines)) if lines else "")
            assert (runtime.engine.chart is not None) == bool(lines)

    def teardown(self) -> None:
        if not hasattr(self, "world"):
            return
        self.mend_everything()
        self.come_back()
        assert not audit(self.world.events, self.world.profile)
        sent = (e for e in self.world.events if isinstance(e, Tx) and e.link == VEHICLE)
        assert not crowded(sent)

    def mend_everything(self) -> None:
        world = self.world
        for name in self.failed:
            world.mend(name)
        self.links_get_other(0.0, 0.0, 0.0, 0.0)
        world.store.full, world.store.death = False, None
        for boat in world.boats:
            world.part(boat)
        self.begins_anew()
        self.do(lambda: world.run(15.0))
        self.boat(0)
        self.do(
            lambda: world.over_the_air(world.boats[0], [b"@NSOOOCCO$", b"@SP,2000,240,100,10,$"])
        )
        self.do(lambda: world.run(6.0))

    def come_back(self) -> None:
        world, known = self.world, MISSIONS[0]
        if world.runtime.state.startswith("idle"):  # whatever is stored, and with lines of another
            mixed = [known.lines[0], *MISSIONS[1].lines[1:]]
            lines = [MissionLine(len(mixed), i, line) for i, line in enumerate(mixed, 1)]
            self.do(lambda: world.over_the_air(world.boats[0], [encode(line) for line in lines]))
            talk = self.held(upload(known.lines, known.digest, quiet))
            assert talk.failure is None, talk.failure
            assert world.store.content.lines == known.lines
        assert self.held(order(Order.SURFACE)).failure is None
        for _ in range(int(PATIENCE / 5.0)):
            if world.runtime.state == SURFACED:
                break
            self.do(lambda: world.run(5.0))
        assert world.runtime.state == SURFACED
        assert self.held(clear()).result == "cleared"
        talk = self.held(upload(known.lines, known.digest, quiet))
        assert talk.failure is None
        assert world.store.content.lines == known.lines
        assert self.held(start(patience=60)).result == "started"
        assert world.runtime.state.startswith("autonomous/")

    def held(self, talk) -> Conversation:
        world = self.world
        begun: list[Conversation] = []
        self.do(lambda: begun.append(world.hold(world.boats[0], talk)))
        for _ in range(100):
            if begun[0].over:
                return begun[0]
            self.do(lambda: world.run(1.0))
        raise AssertionError("a conversation that does not end")


TestServeCore = pytest.mark.proof(ServeCore.TestCase)


def test_every_fault_of_the_board_is_one_of_the_table() -> None:
    assert set(BOARD) <= set(FAULTS)


def test_who_dies_in_the_first_write_of_a_start_is_started_again() -> None:
    state = ServeCore()
    state.begin("as-built", 0)
    state.says(number=0, word=b"@MMF5$")
    state.starts(number=0)
    state.world.store.death = Death.BEFORE
    state.is_killed()
    state.time(seconds=0.1)  # by the timer that follows the stop at once
    assert state.world.store.death is None, "the start had something to write"
    assert state.world.program.lives
    state.teardown()
