"""Whether the vehicle is near enough to home to start a mission, as the check assumed.

What does not live here: where home is, and by which fix that is known (orders).
"""

from __future__ import annotations

from mission.engine.bounds import Bounds


def too_far(far: float, bounds: Bounds, within: float) -> str:
    """Why a start ``far`` m from home is refused, and what to do; "" if it is allowed. ``within``:
    m from home, which the mission assumes of its start."""
    if far > bounds.radius:
        return f"home is {far:.0f} m away, the radius in force is {bounds.radius:g} m"
    if far > within:
        return (
            f"home is {far:.0f} m away, and the mission was proved for a start within "
            f"{within:g} m of it; go nearer, or let the mission assume start "
            f"{10.0 * -(-far // 10.0):.0f}"
        )
    return ""
