"""Set the system's clock by @ST, if the configuration says so (R10).

What does not live here: reading it (serve).
"""

from __future__ import annotations

import time
from datetime import UTC, datetime


def set_system_clock(local: str, utc_offset: float) -> str:
    """Set the clock; why it was not set, "" if it was. ``local``: ``YYYY-MM-DDThh:mm:ss``;
    ``utc_offset``: s."""
    there = datetime.fromisoformat(local).replace(tzinfo=UTC).timestamp()
    try:
        time.clock_settime(time.CLOCK_REALTIME, there - utc_offset)
    except OSError as error:
        return error.strerror or str(error)
    return ""
