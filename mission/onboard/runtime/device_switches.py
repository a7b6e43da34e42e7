"""The Pi's nodes (R13): which are open, and a switch that is answered when all have changed.

    bit   0    1      2      3     4       5        of @ACK_NI, and the letters of @NS
    node  Pi   STM32  BDGPS  UACM  CAMERA  AUTO

AUTO closes at once. The others belong to processes: a request leaves as
``Tx(link="nodes", data=b"CAMERA O")``, and the owner of the process answers with
``Rx(link="nodes", data=b"CAMERA O\\n")`` when it is done. If not all have changed within 5 s, the
switch is answered N. AUTO opens when all others are as requested.

What does not live here: who may switch (operator_server, node_switching), what AUTO does (engine),
processes (serve.processes).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mission.onboard.configuration import LinkUrls

NAMES = ("Pi", "STM32", "BDGPS", "UACM", "CAMERA", "AUTO")
OWN = ("Pi", "AUTO")  # no process behind them
LINK = "nodes"
CHANGED_WITHIN_S = 5.0
OPEN, CLOSE = "O", "C"


@dataclass(frozen=True, slots=True)
class _Pending:
    wanted: Mapping[str, bool]
    deadline: float


class DeviceSwitches:
    """``configured`` names the nodes with a process that runs from the start."""

    def __init__(self, configured: frozenset[str]) -> None:
        self._configured = configured
        self._open = {name: name in OWN or name in configured for name in NAMES}
        self._asked = dict(self._open)  # what each process was last asked to become
        self._pending: _Pending | None = None

    def is_open(self, name: str) -> bool:
        return self._open[name]

    def stays_open(self, name: str) -> bool:
        """Whether the node is open, and no request will close it."""
        pending = self._pending is None or self._pending.wanted[name]
        return self._open[name] and self._asked[name] and pending

    def reopen(self, name: str) -> bytes:
        """Return the request to the process that opens a node which is closed or about to close;
        b"" if none is needed. A pending switch that would close it is given up."""
        if self.stays_open(name) or name not in self._configured:
            return b""
        if self._pending is not None and not self._pending.wanted[name]:
            self._pending = None
        self._asked[name] = True
        return f"{name} {OPEN}".encode()

    def are(self, switches: str) -> bool:
        """Whether all nodes are as these letters say; the Pi's own is ignored (E-T2)."""
        named = zip(NAMES[1:], switches[1:], strict=True)
        return all(self._open[name] == (letter == OPEN) for name, letter in named)

    @property
    def mask(self) -> int:
        return sum(1 << bit for bit, name in enumerate(NAMES) if self._open[name])

    def switch(self, switches: str, now: float) -> list[bytes]:
        """Begin a switch; return the requests to processes. ``settle`` tells when it is done."""
        wanted = {name: letter == OPEN for name, letter in zip(NAMES, switches, strict=True)}
        wanted["Pi"] = True  # E-T2: the Pi does not close itself
        self._open["AUTO"] &= wanted["AUTO"]
        self._pending = _Pending(wanted, now + CHANGED_WITHIN_S)
        others = [name for name in NAMES if name not in OWN]
        asks = [n for n in others if not self._open[n] == self._asked[n] == wanted[n]]
        self._asked |= {name: wanted[name] for name in others}
        return [f"{name} {OPEN if wanted[name] else CLOSE}".encode() for name in asks]

    def changed(self, data: bytes) -> None:
        """Take in a process's report of its node's state; lines that name no node are ignored."""
        for line in data.decode("ascii", "replace").splitlines():
            name, _, letter = line.partition(" ")
            if name in NAMES and name not in OWN and letter in (OPEN, CLOSE):
                self._open[name] = letter == OPEN

    def settle(self, now: float) -> str | None:
        """End the pending switch if it is decided. Return, once, which nodes have not changed in
        time, as text; "" if all have. None: not decided yet, or nothing is pending."""
        if self._pending is None:
            return None
        wanted = self._pending.wanted
        left = [n for n, value in wanted.items() if n not in OWN and self._open[n] != value]
        if left and now < self._pending.deadline:
            return None
        self._pending = None
        if not left:
            self._open["AUTO"] = wanted["AUTO"]
        late = f"not changed within {CHANGED_WITHIN_S:.0f} s: {' and '.join(left)}"
        return f"{late}; the Pi's journal says why" if left else ""

    def next_timer(self) -> float | None:
        return self._pending.deadline if self._pending else None


def with_process(links: LinkUrls) -> frozenset[str]:
    """The nodes whose processes run from the start."""
    there = {"STM32": True, "BDGPS": links.gps is not None, "UACM": links.modem is not None}
    return frozenset(name for name, runs in there.items() if runs)
