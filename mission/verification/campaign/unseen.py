"""Rules whose absence no flight of a vehicle can notice, each with the reason.

What does not live here: the rules (broken), which scenes are staged on which vehicle (staging).
"""

from __future__ import annotations

from collections.abc import Mapping

from mission.verification.campaign import staging
from mission.verification.campaign.broken import BROKEN

_Reasons = Mapping[str, tuple[str, ...]]
_OF_BOARDS: _Reasons = {
    "its board answers nothing": ("limit no answer", "refused set"),
    "its board is told again and again, whatever the rule says": (
        *("stop again", "stop doubted", "line doubted"),
    ),
    "its board repeats the newest, and nothing waits before that": (
        "relays first",
        "relays between",
        "lift again",
        "gap",
    ),
    "the check refuses what would be held; test_outer_loop tries it": ("unconfirmed loop",),
}
_IN_WATER: _Reasons = {
    "what sinks at rest without a depth is excused; test_engine_ascent tries it": ("goes under",),
    "the depth in force acts before it, at rest whatever sinks is brought up": (
        "limit hard depth",
    ),
    "a depth that is contradicted is unknown, and acts as such 6 s later": (
        "limit depth contradicted",
    ),
    staging.NO_RECEIVER: (
        *("limit course against heading", "stuck receiver", "fixes below", "fix under water"),
        *("fixes against movement", "fixes too early"),
    ),
    staging.NO_SUCH_FAULT: (
        *("limit heading does not follow", "belief", "depth that moves", "moving depth"),
        *("healthy heading", "healthy attitude", "healthy altitude", "above the bottom"),
    ),
    "takes a rise through the surface as a silence ends; exhaustive has it in every state": (
        "surface behind a silence",
    ),
    "takes a silence that begins at the surface; exhaustive has it in every state": (
        "surface by one report",
    ),
    "a depth has to change first: either holds without it": ("surface behind a restart",),
    staging.UNKNOWN_AT_REST: ("sank unseen",),
    "D12 brings it up before a second round": ("pushed down again",),
    "W has its bytes there, so that it is none of the ways": ("way U12",),
}
_NO_THRUSTERS: _Reasons = {"it reports no thrusters": ("limit brown-out",)}
_AREAS: _Reasons = {
    staging.NO_HEADING_AT_SURFACE: ("areas",),
}
_NO_PLACE: _Reasons = {staging.NO_PLACE: ("limit radius", "limit uncertain", "areas")}
_NO_LEAK: _Reasons = {staging.NO_LEAK: ("limit leak",)}
_ON_LAND: _Reasons = {
    staging.ON_LAND: (
        *("limit depth", "limit hard depth", "limit unexplained descent", "limit no progress"),
        "slow descent",
        *("limit depth contradicted", "limit depth unknown", "limit roll-over"),
        *("limit heading does not follow", "limit course against heading", "depth margin"),
        *("surface at once", "stuck receiver", "fixes below", "fix under water", "belief"),
        "depth that moves",
        *("moving depth", "fixes against movement", "fixes too early"),
        *("surface behind a silence", "surface by one report", "unchanged depth"),
        *("surface behind a restart", "sank unseen", "pushed down again", "pushed in the dark"),
        *(
            "blind thrust",
            "goes under",
            "sinks at rest",
            "stays down",
            "held up",
            "rest with AUTO closed",
        ),
        *("way U12", "way X0", "way D12", "ways in turn", "upside down", "cleared below"),
        *("started below", "healthy depth", "healthy heading", "healthy attitude"),
        *("healthy altitude", "above the bottom", "blind leg"),
    ),
}


_WEIGHT: _Reasons = {
    "its drop weight brings it up before a round is over": ("way D12", "upside down"),
}
_UNCONFIRMED: _Reasons = {
    staging.HOLDS_NOTHING: ("limit no progress", "blind leg"),
    staging.NO_BATTERY: ("limit voltage",),
    "without a place nothing but its depth can prove the surface: such a flight does not end": (
        *("unchanged depth", "pushed in the dark"),
    ),
}
_STANDS: _Reasons = {
    "what drives stands wherever it stops, and that is all": ("restart", "orderly end"),
}


def _of(*groups: _Reasons) -> Mapping[str, str]:
    return {rule: why for reasons in groups for why, rules in reasons.items() for rule in rules}


UNSEEN: Mapping[str, Mapping[str, str]] = {
    "coreboard": _of(_OF_BOARDS, _IN_WATER, _NO_THRUSTERS, _AREAS),
    "rov": _of(_OF_BOARDS, _IN_WATER, _UNCONFIRMED, _NO_PLACE, _NO_LEAK),
    "robot": _of(_OF_BOARDS, _ON_LAND, _STANDS, _NO_THRUSTERS, _NO_PLACE, _NO_LEAK),
    "mainboard": _of(_OF_BOARDS, _IN_WATER, _NO_THRUSTERS, _AREAS, _WEIGHT),
}


def unseen(rule: str, vehicle: str) -> str:
    """Return why no flight can notice a broken rule, "" if one can."""
    return UNSEEN[vehicle].get(rule, "") if vehicle in UNSEEN else BROKEN[rule].reason
