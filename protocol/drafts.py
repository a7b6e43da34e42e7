"""Drafts of frozen values: filled, a draft becomes what it was a draft of by a change of its class.

Setting the slots of a frozen class costs two to four times as much (tests/bench/bench_tricks.py);
a log has thousands of reports, and noise a fault for every few bytes. Compiled code cannot swap the
class of an object of its own, so these are left to the interpreter (``mission.model.compiled``).

What does not live here: what fills them (``protocol.framing``, ``protocol.vehicles.sd_stream``).
"""

from __future__ import annotations

from protocol.messages import FrameFault, Telemetry


class FaultDraft:
    __slots__ = FrameFault.__slots__


class TelemetryDraft:
    __slots__ = Telemetry.__slots__
