"""Convert records of the first form to today's form: the same values, other bytes.

    rx             f64 t | f64 first | link NUL address NUL data
    tx             link NUL address NUL reason NUL data
    fault          link NUL kind NUL offset NUL length
    other inputs   f64 t | texts, NUL between them
    other kinds    JSON, as today

``f64`` is little-endian. What does not live here: files (reading).
"""

from __future__ import annotations

import struct

from links.base import Rx
from mission.model import Record, Tx
from mission.onboard.runtime import records as rec
from protocol.messages import FrameFault

_T = struct.Struct("<d")


def as_today(record: Record) -> Record:
    """Convert a record. Raises ValueError if its payload is not of the first form."""
    try:
        return _as_today(record)
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError(str(error)) from error


def _as_today(record: Record) -> Record:
    kind, payload = record.kind, record.payload
    if kind == rec.RX:
        link, address, data = payload[2 * _T.size :].split(b"\0", 2)
        now, first = (_T.unpack_from(payload, at)[0] for at in (0, _T.size))
        return rec.rx_record(Rx(first, link.decode(), data, address.decode()), now)
    if kind == rec.TX:
        link, address, reason, data = payload.split(b"\0", 3)
        tx = Tx(record.t, link.decode(), data, reason.decode(), address.decode())
        return rec.tx_record(tx)
    if kind == rec.FAULT:
        name, what, offset, length = payload.decode().split("\0")
        return rec.fault_record(record.t, name, FrameFault(int(offset), what, int(length)))
    if kind in rec.INPUTS:
        texts = payload[_T.size :].decode()
        now = _T.unpack_from(payload)[0]
        return rec.input_record(now, kind, *(texts.split("\0") if texts else ()))
    return record
