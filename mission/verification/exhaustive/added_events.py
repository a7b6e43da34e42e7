"""Events of added sensors: they send wrong values, in every configuration.

The values are wild speeds, places and ranges once a second, and the places of a second receiver far
away. None of them is a cause of anything (laws: from region to region only for a cause).

What does not live here: correct readings (events), how wrong values affect the estimate (campaign).
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from links.simulated.firmware.gps import sentence
from mission.verification.exhaustive.cell import Event
from mission.verification.exhaustive.commands import Play, script
from mission.verification.exhaustive.lines import WATER, told
from mission.verification.exhaustive.world import World

_SECONDS, _NEAR = 11, 4  # s of an event; s of those with places near by
_Says = Callable[[Random, int], bytes]


def _lies(says: _Says) -> Play:
    def play(world: World) -> None:
        rng = Random(16)
        for second in range(_SECONDS):
            world.hear_added(says(rng, second))
            world.wait(1.0)

    return script(play)


def _log(rng: Random, second: int) -> bytes:
    ahead, across = (rng.randint(-9000, 9000) for _ in range(2))
    said = f":WS,+00000,{ahead:+06d},+00000,A\r\n:BS,{across:+06d},{ahead:+06d},+00000,A\r\n"
    return said.encode() + sentence(f"VDVHW,,T,,M,{rng.uniform(-6.0, 6.0):.2f},N,,K")


def _place(rng: Random, second: int) -> bytes:
    """A place anywhere within 300 m of the shipped missions, later within 5 km."""
    most = 0.16 if second < _NEAR else 2.5  # minutes of an arc
    north, east = 17.2 + rng.uniform(-most, most), 9.2 + rng.uniform(-most, most)
    return sentence(f"VDGLL,30{north:09.6f},N,120{east:09.6f},E,080000.00,A")


def _range(rng: Random, second: int) -> bytes:
    return sentence(f"CAMPR,{rng.randint(1, 2)},1,{rng.uniform(0.0, 2.0):.5f}")


def _second_far_away(world: World) -> None:
    """A second receiver sends places under water, while the first is silent."""
    world.put(world.deep)
    for second in range(_SECONDS):
        place = f"3019.{second:06d},N,12011.000000,E,1,09,0.9,3.0,M,,M,,"
        world.hear_second(sentence(f"GPGGA,08{second:02d}00.00,{place}"))
        world.wait(1.0)


ADDED_EVENTS = (
    *(
        Event(f"an added {name}", _lies(says))
        for name, says in (
            ("log of speed says anything", _log),
            ("acoustic system says any place", _place),
            ("beacon's range is anything", _range),
        )
    ),
    Event(
        "a second receiver says places under water",
        script(_second_far_away),
        also=frozenset({"deeper"}),
        needs=told("depth") | {WATER},
    ),
)
