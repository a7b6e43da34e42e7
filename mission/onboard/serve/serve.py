"""The asyncio shell around the runtime: ports, timers, black box, signals. It decides nothing.

    bytes --Port--RateLimiter-> Runtime.receive -+  (RateLimiter: topside's connections alone)
    timer ----------------> Runtime.handle_timer +--> Tx --> Port | nodes | system clock
    peers ----------------> connected, ... ------+    records --every 0.1 s, thread--> black box

Messages for an operator go to the journal, the state of everything to status.json (health). This
package reads the clocks; the runtime gets times with its inputs. The engine's time begins with the
runtime, the ports' with serve; both run ``speed`` times as fast as real time (a demo). A thread
imports the filter once the runtime is there; until it is loaded, @AA is refused.

An error of the program ends the runtime, not serve: it is logged, and a new runtime begins as after
a restart (what was under way surfaces, nodes are as at first), with a black box of its own.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from functools import partial
from typing import Any

from links.base import Rx
from mission.model import Tx
from mission.onboard.runtime.command_target import MODEM, Peer
from mission.onboard.runtime.device_switches import LINK as NODES
from mission.onboard.runtime.records import Observer
from mission.onboard.runtime.runtime import CLOCK, Runtime
from mission.onboard.serve import health
from mission.onboard.serve.alarm_watch import AlarmWatch
from mission.onboard.serve.journal import Journal, Several
from mission.onboard.serve.leaving import MARGIN_S, USUAL_S, Leaving
from mission.onboard.serve.listening import (
    Ready,
    listening,
    listening_to_viewers,
    open_to_all,
    reached_at,
)
from mission.onboard.serve.ports import Port
from mission.onboard.serve.preload import judge_ahead, prepare
from mission.onboard.serve.processes import Processes
from mission.onboard.serve.provision import Provision
from mission.onboard.serve.rate_limiter import RateLimiter, host_of
from mission.onboard.serve.recording import ClosesParts, Recording, leave_parts
from mission.onboard.serve.systemclock import set_system_clock
from mission.onboard.serve.validation_queue import ValidationQueue
from mission.onboard.serve.view import view
from mission.onboard.serve.viewing import Seen, Viewing
from mission.onboard.serve.watchdog import Watchdog

VEHICLE, GPS, GPS2, TOPSIDE, SENSORS = "vehicle", "gps", "gps2", "topside", "sensors"
NODE_OF = {VEHICLE: "STM32", GPS: "BDGPS", MODEM: "UACM"}
FIRST_S = 1.0  # s of real time that the first W after a restart waits for its port
REBIRTH_S = 1.0  # s of real time between an error of the program and the next runtime
EARLY_S = 0.002  # s: a timer that fires this much too early counts as in time


class Server:
    """``tell`` gets the journal's lines; ``ready`` is called once."""

    def __init__(
        self,
        got: Provision,
        tell: Callable[[str], None],
        ready: Callable[[Ready], None] = lambda ready: None,
        speed: float = 1.0,
        observer: Observer | None = None,
        leave_within: float = USUAL_S - MARGIN_S,
        close_parts: ClosesParts = leave_parts,
    ) -> None:
        self._got = got
        self._configuration, self._vehicle, self._store = got.configuration, got.vehicle, got.store
        viewers = got.configuration.links.monitor
        self.viewing = Viewing(listening_to_viewers(viewers), self._see, tell) if viewers else None
        self._journal = Journal(self.viewing.told(tell) if self.viewing else tell, time.monotonic)
        if self.viewing:
            self.viewing.tell = partial(self._journal.warning, kind="viewers")
        self._tell, self._ready, self._speed = self._journal.warning, ready, speed
        self._observer = Several(self._journal, *([observer] if observer else []))
        self._limiter, self._began = RateLimiter(time.monotonic()), time.monotonic()
        self._recording = Recording(self._tell, close_parts)
        self.validation = ValidationQueue(self._hear, self._spawn, got.configuration.tolerances)
        self._alarms = AlarmWatch(
            self._journal,
            lambda names: self._do(lambda r: r.take_alarms(names, self.now())),
            (*got.faults, *got.damage),
            in_real_time=speed == 1.0,
        )
        self._commander: Peer | None = None
        self._runtime: Runtime | None = None
        self._zero = 0.0  # zero of the engine's time, in the ports' time
        self._timer: asyncio.TimerHandle | None = None
        self._peers: dict[str, frozenset[str]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._leaving = Leaving(leave_within, lambda: self._runtime, self._order_end, self._tell)
        self._announced, self._watchdog = False, Watchdog()

    async def run(self) -> None:
        """Run until ``stop``."""
        links = self._configuration.links
        urls = {TOPSIDE: listening(links.topside), VEHICLE: links.vehicle, GPS: links.gps}
        urls |= {MODEM: links.modem, SENSORS: links.sensors, GPS2: links.gps2}
        self._ports = {
            name: Port(name, url, self._readable, self._changed, self._tell)
            for name, url in urls.items()
            if url is not None
        }
        nodes = {NODE_OF[name]: port for name, port in self._ports.items() if name in NODE_OF}
        camera = self._configuration.camera
        self._processes = Processes(nodes, camera, self._tell, self._changed_node)
        self._spawn(self._ports[VEHICLE].keep_open())
        await self._ports[VEHICLE].tried(FIRST_S)
        await self._begin()
        for name, port in self._ports.items():
            if name != VEHICLE:
                self._spawn(port.keep_open())
        if self.viewing is not None:
            self._spawn(self.viewing.keep())
        self._spawn(self._recording.keep_box())
        self._spawn(self._recording.keep_status(self._configuration.folder, self._health))
        board = self._ports[VEHICLE]
        self._spawn(self._recording.keep_working(self._got, lambda: board.heard is not None))
        self._watchdog.ready()  # the runtime runs, even if topside's port cannot be opened
        await self._leaving.ordered.wait()
        await self._end()

    def stop(self) -> None:
        """End in order the first time: surface first (leaving). The second time, end at once."""
        self._leaving.signal()

    def hang_up(self) -> None:
        self._tell("the terminal that serve was started from is gone; serve goes on")

    def now(self) -> float:
        """The engine's time."""
        return self._up() - self._zero

    def _up(self) -> float:
        """The ports' time: a new engine does not reset it."""
        return (time.monotonic() - self._began) * self._speed

    # --- the runtime ---------------------------------------------------------------------------

    async def _begin(self) -> None:
        """Start a runtime with its black box, from what the store holds."""
        wall = time.time()
        self._recording.begin(self._configuration.log, wall)
        self._zero = self._up()
        try:
            self._runtime = Runtime(
                self._configuration,
                self._vehicle,
                self._store,
                self._recording.sinks,
                wall=wall,
                observer=self._observer,
            )
        except Exception as error:
            self._fault(error)
            return
        self._alarms.begin()
        self._ports[VEHICLE].keep_gaps(self._runtime.gap)
        for name, port in self._ports.items():
            self._peers[name] = frozenset()
            self._meet(port)
        self._spawn(self._navigate(self._runtime))
        for rx in self.validation.take_missed(self.now()):
            self._hear(rx)
            if rx.address not in self._ports[rx.link].peers:  # it has disconnected meanwhile
                self._disconnect(rx.link, rx.address)
        self._schedule()

    async def _navigate(self, runtime: Runtime) -> None:
        """Import the filter and the check in a thread, because that takes a while."""
        try:
            navigation = await asyncio.to_thread(prepare, runtime)
        except Exception as error:
            self._journal.error("navigation cannot be loaded, no mission can start:", error)
            return
        if runtime is self._runtime:
            self._do(lambda d: d.set_navigation(navigation, self.now()))
            await asyncio.to_thread(judge_ahead, runtime)

    def _do(self, call: Callable[[Runtime], list[Tx]]) -> None:
        """Give the runtime one input, and send everything that leaves because of it."""
        if self._runtime is None:
            return
        try:
            out = call(self._runtime)
        except Exception as error:
            self._fault(error)
            return
        for tx in out:
            self._leave(tx)
        if self._runtime.commander.peer != self._commander:
            self._hand_over(self._runtime.commander.peer)
        self._watchdog.fed(time.monotonic())
        self._schedule()

    def _fault(self, error: Exception) -> None:
        """Log an error of the program itself, and start another runtime; serve continues."""
        self._runtime = None
        if self._timer is not None:
            self._timer.cancel()
        self._spawn(self._begin_again())
        self._journal.error("a fault of the program; what was under way surfaces:", error)

    async def _begin_again(self) -> None:
        self._spawn(self._processes.begin_again())
        await asyncio.sleep(REBIRTH_S)
        if not self._leaving.over:
            await self._begin()
        if self._leaving.ordered.is_set():
            self._order_end(self._leaving.last)

    # --- in ----------------------------------------------------------------------------------

    def _readable(self, port: Port, due: float = 0.0) -> None:
        if port.name != VEHICLE:  # after a stall, its reports have waited, too: they come first
            self._readable(self._ports[VEHICLE])
        heard = [rx._replace(t=rx.t - self._zero) for rx in port.receive(max(self._up(), due))]
        self._meet(port)
        if port.name == TOPSIDE:
            heard = self._sifted(port, heard)
        for rx in heard:
            if port.name in (TOPSIDE, MODEM) and self._runtime is not None:
                self.validation.hear(rx, self._runtime)
            else:
                self._hear(rx)
        self._part(port)

    def _hear(self, rx: Rx) -> None:
        if self._runtime is None and rx.link in (TOPSIDE, MODEM):
            self.validation.miss(rx)
        self._do(lambda runtime: runtime.receive(rx, self.now()))
        if self._runtime is not None and self._runtime.commander.knows(Peer(rx.link, rx.address)):
            self._ports[rx.link].vouch(rx.address)

    def _sifted(self, port: Port, heard: list[Rx]) -> list[Rx]:
        """Return what the rate limiter lets pass, bytes with an X or W first."""
        for refusal, times in port.refusals().items():
            text = f"topside: {refusal.host} turned away: {refusal.why}"
            self._journal.warning(text, times=times, kind="connections turned away")
        return self._limiter.sift(heard, time.monotonic(), self._flooded)

    def _flooded(self, host: str) -> None:
        self._journal.warning(f"topside: {host} floods; only its X and W are heard", kind="floods")

    def _changed(self, port: Port) -> None:
        if port.link is None:
            self._part(port)
        elif port.name == MODEM:
            self._meet(port)
        elif port.name == VEHICLE:  # it was lost: its first opening comes before the runtime
            self._do(lambda runtime: runtime.connected(VEHICLE, "", self.now()))
        elif port.name == TOPSIDE and not self._announced:
            self._announced = True
            self._ready(Ready(reached_at(port.url), self._recording.path))
            if open_to_all(port.url):
                self._tell(f"whoever reaches {port.url} can command the vehicle: add "
                           "?allow=ADDRESSES to it, or listen with tls-listen://")  # fmt: skip
        self._schedule()

    def _meet(self, port: Port) -> None:
        for address in [a for a in port.peers if a not in self._peers.get(port.name, ())]:
            self._peers[port.name] = self._peers.get(port.name, frozenset()) | {address}
            if address:
                self._journal.info(f"topside: {address} is connected", host_of(address), "arrivals")
            self._do(lambda d, a=address: d.connected(port.name, a, self.now()))  # type: ignore[misc]

    def _part(self, port: Port) -> None:
        for address in self._peers.get(port.name, frozenset()) - set(port.peers):
            self._peers[port.name] = self._peers[port.name] - {address}
            self._limiter.forget(address)
            if address:
                self._journal.info(f"topside: {address} is gone", host_of(address), "departures")
            self._disconnect(port.name, address)

    def _disconnect(self, link: str, address: str) -> None:
        self.validation.part(
            link, address, lambda: self._do(lambda r: r.disconnected(link, address, self.now()))
        )

    def _schedule(self) -> None:
        """Set one timer for whatever is due next."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        dues = [event - self._zero for event, _ in self._events()]
        if self._runtime is not None and (timer := self._runtime.next_timer()) is not None:
            dues.append(timer)
        due = min(dues, default=float("inf"))
        delay = max(0.0, (due - self.now()) / self._speed)
        delay = min(delay, self._watchdog.remaining(time.monotonic()))
        if delay != float("inf"):
            self._timer = asyncio.get_running_loop().call_later(delay, self._due, due)

    def _events(self) -> list[tuple[float, Port]]:
        """When to check each port even if nothing comes."""
        events = ((port.next_event(), port) for port in self._ports.values())
        return [(event, port) for event, port in events if event is not None]

    def _due(self, due: float) -> None:
        self._timer = None
        now = self.now()
        if now < due <= now + EARLY_S * self._speed:
            now = due
        for event, port in self._events():
            if event - self._zero <= now:
                self._readable(port, event)
        self._readable(self._ports[VEHICLE])
        self._do(lambda runtime: runtime.handle_timer(now))

    # --- out ---------------------------------------------------------------------------------

    def _hand_over(self, commander: Peer | None) -> None:
        """Write both names to the journal (R12)."""
        loser, self._commander = self._commander, commander
        if commander is not None:
            self._journal.commands(str(commander), str(loser or ""))

    def _leave(self, tx: Tx) -> None:
        sent = True
        if tx.link == NODES:
            self._spawn(self._switch(tx.data))
        elif tx.link == CLOCK:
            local, offset = tx.data.decode("ascii"), self._configuration.utc_offset
            if why := set_system_clock(local, offset):
                self._tell(f"the system's clock was not set: {why}")
        elif (port := self._ports.get(tx.link)) is not None:
            sent = port.send(tx.data, self._up(), tx.address)
            self._part(port)
        if tx.link == VEHICLE:
            self._journal.commanded(tx, sent)
            if not sent:
                self._alarms.unsent()
        else:
            self._journal.answered(tx)

    async def _switch(self, request: bytes) -> None:
        if answer := await self._processes.switch(request):
            self._changed_node(answer)

    def _changed_node(self, answer: bytes) -> None:
        self._do(lambda runtime: runtime.receive(Rx(self.now(), NODES, answer)))

    def _health(self) -> health.Health | None:
        """The health now. The journal also writes the counts whose minute is over."""
        self._journal.settle()
        if self._runtime is None:
            return None
        faults, dropped = self._recording.tally.faults, {TOPSIDE: self._limiter.dropped}
        return health.Health(
            up_s=time.monotonic() - self._began,
            wall=time.time(),
            links=health.of_ports(self._ports, self._up(), faults, dropped),
            **health.of_drive(self._runtime, self._vehicle, self.now()),
            **health.of_box(self._recording.box),
            broken=self._alarms.broken,
            ascent_only=self._configuration.ascent_only,
            alarms=self._alarms.look(self._runtime, self._ports, self._recording, self.now()),
        )

    def _see(self) -> Seen | None:
        """What viewers see: the time, the state, the lines of the stored mission; None without a
        runtime."""
        if self._runtime is None:
            return None
        state = view(self._runtime, self._alarms.standing, self.now())
        return self.now(), state, self._store.content.lines

    # --- tasks -------------------------------------------------------------------------------

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            self._journal.error("a task of the program has failed:", error)

    def _order_end(self, at_once: bool) -> None:
        self._do(lambda runtime: runtime.end(self.now(), at_once=at_once))

    async def _end(self) -> None:
        self._watchdog.stopping()
        await self._leaving.leave()
        self._runtime = None
        if self._timer is not None:
            self._timer.cancel()
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self._processes.end()
        await self._recording.shut()
        self._recording.end()
