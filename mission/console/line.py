"""One connection to a vehicle, kept open: conversations, the stick, and a keep-alive (the beat).

    closed --open--> open --lost: nothing came for ``LOST_S`` (steering: ``STEERING_S``)--> closed
                     one conversation at a time, the beat (@AE) every second between them;
                     an urgent one goes first, and continues over the next connection;
                     a look goes last

The timeout of an answer follows the link's round-trip time (latency). A lost link is aborted, and
its waiting data are dropped: a stick of some seconds ago is no command. By modem, where one side
speaks at a time and delays of seconds are usual, there is neither beat nor loss.

What does not live here: what is sent (topside), who may send it (vehicle).
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from links import open_link
from links.base import Link, LinkClosed, LinkError
from mission.console.latency import Latency
from mission.topside.console import NAME, Talk, Unreachable
from mission.topside.helm import Helm
from mission.topside.stick import LOST_S as STEERING_S
from mission.topside.stick import forget
from mission.topside.underwater import Submerged, modem_address
from mission.topside.upload import Ask, Conversation, OperatorError, Script, is_report
from protocol.messages import StateQuery, StateReport, StoreQuery
from protocol.topside import Answer, encode

LOST_S = 6.0
BEAT_S, STEERING_BEAT_S = 1.0, 0.5
AGAIN_S = 1.0
TICK_S = 0.25
STATE_QUERY = encode(StateQuery())
OPENING = 2  # links opened at a time: the one in use, and the next


class NotSent(OperatorError):
    """The vehicle has not received it."""


@dataclass(slots=True)
class _Job:
    """``done``: None for a beat. ``idle``: a look, which no operator asked for."""

    talk: Talk
    done: asyncio.Future[str] | None = None
    urgent: bool = False
    idle: bool = False
    begun: bool = False

    @property
    def is_meant(self) -> bool:
        return self.done is not None and not self.idle


class Line:
    """``keep`` runs it. Raises WrongAddress. Times are of the monotonic clock."""

    def __init__(self, url: str) -> None:
        modem = modem_address(url)
        self.acoustics = None if modem is None else modem.acoustics
        self._url = url if modem is None else modem.link
        self.helm = Helm()
        self.problem = "not connected so far"
        self.answered: float | None = None
        self.state: StateReport | None = None
        self.sent = b""  # the stick's last commands
        self.is_uploading = False
        self._opener = ThreadPoolExecutor(OPENING)  # its own: others may wait for a name or a peer
        self._link: Link | None = None
        self._next: Link | None = None
        self._job: _Job | None = None
        self._waiting: deque[_Job] = deque()
        self._stir = asyncio.Event()
        self._latency = Latency(LOST_S)
        self._heard = self._beat = self._told = 0.0

    @property
    def is_open(self) -> bool:
        return self._link is not None

    @property
    def is_busy(self) -> bool:
        """Whether a conversation that somebody asked for, or the stick, is active."""
        jobs = (self._job, *self._waiting)
        return any(job and job.is_meant for job in jobs) or not self.helm.is_silent

    def silence(self, now: float) -> float | None:
        """s since the last answer; None if it is not open, or has not been answered."""
        if self._link is None or self.answered is None:
            return None
        return max(0.0, now - self.answered)

    def stir(self) -> None:
        """Wake the loop: the stick has moved."""
        self._stir.set()

    # --- what is said ------------------------------------------------------------------------

    async def say(self, script: Script, *, urgent: bool = False, idle: bool = False) -> str:
        """Run a script and return its result. Raises OperatorError, NotSent without a connection.
        An urgent script waits for a connection; an idle one breaks off for all others."""
        if self.acoustics is None:
            return await self.hold(self._conversation(script), urgent=urgent, idle=idle)
        return await self.hold(Submerged(script, self.acoustics), urgent=urgent, idle=idle)

    def _conversation(self, script: Script) -> Conversation:
        return Conversation(script, lambda: self._latency.patience_s)

    async def hold(self, talk: Talk, *, urgent: bool = False, idle: bool = False) -> str:
        if self._link is None and not urgent:
            raise NotSent(self.problem)
        job = _Job(talk, asyncio.get_running_loop().create_future(), urgent, idle)
        assert job.done is not None
        if urgent:
            self._give_way()
        elif not idle:
            self._look_no_more()
        self._waiting.append(job)
        self._stir.set()
        return await job.done

    def _give_way(self) -> None:
        """Break off the current conversation, and drop all that wait, older orders included."""
        _fail(self._job, "broken off by an order; it may or may not have been done")
        self._job = None
        while self._waiting:
            _fail(self._waiting.popleft(), "not said: an order came before it")

    def _look_no_more(self) -> None:
        """Break off looks, so that a request need not wait for a look over a slow radio."""
        for job in [job for job in (self._job, *self._waiting) if job and job.idle]:
            _fail(job, "the look broke off: something else is said")
        self._waiting = deque(job for job in self._waiting if not job.idle)
        if self._job is not None and self._job.idle:
            self._job = None

    async def renew(self) -> None:
        """Open the next connection before closing this one. For the vehicle it is another operator,
        who does not command. By modem there is only one."""
        if self.acoustics is None:
            self._next = await self._open()
            self._stir.set()

    # --- the connection ------------------------------------------------------------------------

    async def keep(self) -> None:
        """Run until cancelled."""
        try:
            while True:
                link, self._next = self._next or await self._open(), None
                if link is None:
                    await asyncio.sleep(AGAIN_S)
                    continue
                before = self.answered
                await self._use(link)
                if self._next is None and self.answered == before:  # opened, closed unanswered
                    await asyncio.sleep(AGAIN_S)
        finally:
            for job in (self._job, *self._waiting):
                _fail(job, "the console ends")
            self._job = None
            self._waiting.clear()

    def _link_to(self) -> Link:
        return open_link(NAME, self._url)

    async def _open(self) -> Link | None:
        try:
            return await asyncio.get_running_loop().run_in_executor(self._opener, self._link_to)
        except LinkError as error:
            self.problem = str(error)
            return None

    async def _use(self, link: Link) -> None:
        """Use a link until it is lost, or another replaces it."""
        loop, descriptor = asyncio.get_running_loop(), link.fileno()
        self._link, self._heard, self._beat = link, time.monotonic(), 0.0
        self._latency.connected()
        loop.add_reader(descriptor, self._stir.set)
        try:
            while self._next is None:
                self._stir.clear()
                self._turn(link, time.monotonic())
                await self._wait()
        except LinkError as error:
            self.problem = str(error)
            self._lose()
        finally:
            loop.remove_reader(descriptor)
            self._link = None
            link.close()

    def _turn(self, link: Link, now: float) -> None:
        """One turn of the loop: receive, steer, send. Raises LinkError."""
        for rx in link.receive(now):
            self._heard = self.answered = now
            self._hear(rx.data, now)
            if self._job is not None and self._job.begun:
                self._send(link, self._job.talk.receive(rx.data, now), now)
        if self._is_lost(now):
            forget(link)
            raise LinkClosed("the vehicle does not answer")
        self._steer(link, now)
        self._converse(link, now)

    def _hear(self, data: bytes, now: float) -> None:
        if (state := self._latency.heard(data, now)) is not None:
            self.state, self._told = state, now

    def _is_lost(self, now: float) -> bool:
        within = LOST_S + self._latency.way_s if self.helm.is_silent else STEERING_S
        return self.acoustics is None and now - self._heard > within

    def _lose(self) -> None:
        """End the conversations of a lost link. The stick must be let go before it moves anything
        over the next one."""
        self.helm.drop()
        self.state = None
        job = self._job
        if job is not None and not job.urgent:
            _fail(job, f"{self.problem}; what was asked last may or may not have been done")
            self._job = None
        for job in self._waiting:
            if not job.urgent:
                _fail(job, f"{self.problem}; not said: the connection was lost")
        self._waiting = deque(job for job in self._waiting if job.urgent)

    def _steer(self, link: Link, now: float) -> None:
        if words := self.helm.words(now):
            self.sent = b" ".join(words)
            self._send(link, [b"".join(words)], now)

    def _converse(self, link: Link, now: float) -> None:
        job = self._job = self._finished(self._job) or self._following(now)
        if job is None:
            return
        out = job.talk.handle_timer(now) if job.begun else job.talk.begin(now)
        job.begun = True
        self._send(link, out, now)
        self._job = self._finished(job)
        if self._job is None:
            self._stir.set()

    def _finished(self, job: _Job | None) -> _Job | None:
        """Return the job while it runs; once it is over, deliver its result and return None."""
        if job is None or not job.talk.over:
            return job
        if job.done is not None and not job.done.done():
            if job.talk.failure is not None:
                job.done.set_exception(job.talk.failure)
            else:
                job.done.set_result(job.talk.result or "")
        return None

    def _following(self, now: float) -> _Job | None:
        if self._waiting:
            return self._waiting.popleft()
        if self.acoustics is None and now >= self._beat:
            self._beat = now + (BEAT_S if self.helm.is_silent else STEERING_BEAT_S)
            return _Job(Conversation(self._beats()))
        return None

    def _beats(self) -> Script:
        """Send a beat each second, even while earlier answers are still on their way."""
        answer = yield Ask("state", StateQuery(), _is_state, tries=1, by_clock=True)
        if answer is None and time.monotonic() > self._told + self._latency.patience_s:
            self.state = None  # an older program without @AE
            yield Ask("store", StoreQuery(), is_report, tries=1, by_clock=True)
        return ""

    async def _wait(self) -> None:
        now = time.monotonic()
        dues = [now + TICK_S, self.helm.next_timer()]
        if self._job is not None:
            dues.append(self._job.talk.next_timer())
        elif self.acoustics is None:
            dues.append(self._beat)
        due = min(due for due in dues if due is not None)
        with contextlib.suppress(TimeoutError):  # wait_for of Python 3.11 may lose a cancellation
            async with asyncio.timeout(max(0.001, due - now)):
                await self._stir.wait()

    def _send(self, link: Link, frames: list[bytes], now: float) -> None:
        for frame in frames:
            if frame == STATE_QUERY:
                self._latency.asked(now)
            link.send(frame, now)


def _is_state(answer: Answer) -> bool:
    return isinstance(answer, StateReport)


def _fail(job: _Job | None, why: str) -> None:
    if job is not None and job.done is not None and not job.done.done():
        job.done.set_exception(Unreachable(why))
