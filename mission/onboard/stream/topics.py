"""The table of topics: those that a black box holds, and those derived from them.

    RAW       what the runtime records, a topic per kind; its place here is its channel number
    DERIVED   what a reader, or the conversion of a closed part, makes of these (derived)

A new topic is a row, and a method in ``derived``; the reference page is generated from the rows.
What does not live here: payloads (runtime.records), how values are derived (derived).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from mission.onboard.runtime import records as rec
from mission.onboard.stream.schemas import (
    Schema,
    absent,
    count,
    flag,
    listed,
    named,
    number,
    table,
    text,
)
from mission.onboard.stream.wellknown import GEO_JSON, LOCATION_FIX, LOG, POSE_IN_FRAME, SCHEMAS

INPUT, OUTPUT, BEGINNING, DERIVED_ROLE = "input", "output", "start", "derived"
ANYTHING: Schema = {}


@dataclass(frozen=True, slots=True)
class Topic:
    name: str
    says: str
    schema: Schema
    role: str = DERIVED_ROLE
    well_known: str = ""

    @property
    def schema_name(self) -> str:
        return self.well_known or f"auvmission.{self.name}"

    @property
    def metadata(self) -> Mapping[str, str]:
        return {"role": self.role, "says": self.says}


_T = number("s", "the engine's time, 0 when the program began")
_LINK, _ADDRESS = text("link: vehicle, gps, topside, modem, nodes"), text("peer, where it has some")
_DATA = text("the bytes, a character for each (ISO 8859-1)")
_WAY = {"link": _LINK, "address": _ADDRESS}
_PLACE = table("WGS 84", latitude_deg=number("deg"), longitude_deg=number("deg"))
_KNOWN_NUMBER = number("", "", known=False)
_STORE = table(
    "what the store held",
    lines=listed(text("a line of the mission's script"), "the mission"),
    limits=table(
        "the operator's limits, @SP",
        radius=number("m", known=False),
        time=number("s", known=False),
        depth=number("m", known=False),
        voltage=number("V", known=False),
    ),
    under_way=text("what a restart interrupted"),
    damage=listed(text("in words"), "what could not be read"),
)
_EVALUATION: Schema = {
    "type": "array",
    "description": "guard, its result (null: unknown), [variable, value] of each reading",
    "prefixItems": [{"type": "string"}, {"type": ["boolean", "null"]}, {"type": "array"}],
}


def _raw(name: str, says: str, role: str, **fields: Schema) -> Topic:
    optional = ("time_left",) if name == rec.ENDING else ("form",) if name == rec.START else ()
    return Topic(name, says, table(says, optional, **fields), role)


RAW: tuple[Topic, ...] = (
    _raw(
        rec.START, "what a replay begins with", BEGINNING,
        version=text("of the program"), configuration=named(ANYTHING, "as the file has it"),
        vehicle=named(ANYTHING, "as the vehicle file has it, SI units and rad"), store=_STORE,
        wall=number("s", "since 1970 UTC at time 0"), form=count("of the records"),
    ),
    _raw(
        rec.RX, "bytes that came", INPUT,
        t=_T, first=number("s", "when the first of the bytes came"), **_WAY, data=_DATA,
    ),
    _raw(rec.TIMER, "a time at which something was due", INPUT, t=_T),
    _raw(rec.CONNECTED, "an operator, or the vehicle's port that was away", INPUT, t=_T, **_WAY),
    _raw(rec.DISCONNECTED, "an operator who is gone", INPUT, t=_T, **_WAY),
    _raw(rec.NAVIGATION, "the position filter is loaded from here on", INPUT, t=_T),
    _raw(
        rec.STORE, "a write of the store that failed", INPUT,
        t=_T, number=text("of the write"), failed=text("what the disk said"),
    ),
    _raw(
        rec.STEP, "a transition, or a decision without one", OUTPUT,
        t=_T, event=text("what came in"), evaluations=listed(_EVALUATION, "what was asked"),
        exited=listed(text("path"), "states left"), entered=listed(text("path"), "states entered"),
        actions=listed(text("command: reason"), "what was asked of the vehicle"),
        trigger=text("the edge that was taken, empty if none"),
        by=text("why a leg was left", known=False),
    ),
    _raw(
        rec.ESTIMATE, "the position filter, one for each report", OUTPUT,
        t=_T, north=number("m", "of the origin"), east=number("m", "of the origin"),
        depth=number("m", known=False), depth_rate=number("m/s", "down", known=False),
        altitude=number("m", "above the bottom", known=False),
        heading=number("rad", "true", known=False), speed=number("m/s", "through the water"),
        current_north=number("m/s"), current_east=number("m/s"),
        covariance=listed(number("m^2"), "of north and east: nn, ne, ee"),
        sigmas=named(number(""), "standard deviations by variable, SI units and rad"),
        nis=listed(number(""), "of the last update, with its degrees of freedom", known=False),
        fix_age=number("s", known=False), mode=text("none, fix, dead reckoning"),
    ),
    _raw(
        rec.TX, "bytes that left", OUTPUT,
        **_WAY, reason=text("why"), data=_DATA,
    ),
    _raw(
        rec.FAULT, "bytes that were no frame", OUTPUT,
        link=_LINK, kind=text("docs/protocol.md has them"),
        offset=count("of the first byte, in the stream"), length=count("bytes"),
    ),
    _raw(
        rec.ENDING, "the program is to end", INPUT,
        t=_T, time_left=text("now: none; absent: some"),
    ),
    _raw(
        rec.STANDING, "what holds until the next of these", OUTPUT,
        t=_T, origin=absent(_PLACE), radius=number("m", "limit in force"),
        time=number("s", "limit in force"), depth=number("m", "limit in force"),
        voltage=number("V", "limit in force"),
        breached=listed(text("limit"), "limits that are breached"),
        commander=text("who commands, empty if nobody"), digest=text("of the mission"),
    ),
    _raw(
        rec.MISSION, "the mission in the store", OUTPUT,
        t=_T, digest=text("SHA-256 of its canonical text, empty if there is none"),
        lines=listed(text("a line of its script"), "its lines"),
    ),
    _raw(
        rec.ALARMS, "alarms that serve alone sees: links, disk, clock", INPUT,
        t=_T, names=text("of those that stand, with commas between"),
    ),
)  # fmt: skip


def _derived(name: str, says: str, **fields: Schema) -> Topic:
    return Topic(name, says, table(says, **fields))


def _known(name: str, says: str, schema: str) -> Topic:
    return Topic(name, says, SCHEMAS[schema], well_known=schema)


def _maybe(unit: str, says: str = "") -> Schema:
    return number(unit, says, known=False)


TELEMETRY, FIX, AID, STATE = "telemetry", "fix", "aid", "state"
POSITION, FIXES, POSE, JOURNAL, PLAN = "position", "fixes", "pose", "log", "plan"

DERIVED: tuple[Topic, ...] = (
    _derived(
        TELEMETRY, "a report of the vehicle's sensors, decoded",
        t=_T, depth_m=_maybe("m"), altitude_m=_maybe("m", "above the bottom"),
        heading_deg=_maybe("deg", "as the compass gives it"),
        pitch_deg=_maybe("deg", "nose up positive"), roll_deg=_maybe("deg", "starboard down"),
        temperature_c=_maybe("deg C"), control_v=_maybe("V", "control battery"),
        power_v=_maybe("V", "power battery"),
        actuators=named(number("", "share of full thrust, -1 to 1"), "by name, or number"),
        magnetic_ut=listed(number("uT"), "three axes for each magnetometer", known=False),
        latitude_deg=_maybe("deg", "the vehicle's own"), longitude_deg=_maybe("deg"),
        velocity_m_s=listed(number("m/s"), "forward, starboard, down", known=False),
        leak=flag("water inside", known=False),
        faults=listed(text("field:reason"), "fields that are doubtful"),
    ),
    _derived(
        FIX, "a fix of the GPS receiver, decoded",
        t=_T, latitude_deg=number("deg"), longitude_deg=number("deg"),
        accuracy_m=_maybe("m", "one sigma of each axis"), speed_m_s=_maybe("m/s", "over ground"),
        course_deg=_maybe("deg", "over ground"),
        hdop=_maybe("", "horizontal dilution of precision"), elevation_m=_maybe("m"),
        satellites=_maybe("", "how many"), utc=text("as it says", known=False),
    ),
    _derived(
        AID, "what a sensor says that was added, decoded; null where it is of another kind",
        t=_T, kind=text("water, ground, place, range"),
        ahead_m_s=_maybe("m/s", "through the water, or over ground"),
        starboard_m_s=_maybe("m/s", "over ground"),
        latitude_deg=_maybe("deg"), longitude_deg=_maybe("deg"),
        beacon=_maybe("", "its number"), travel_s=_maybe("s", "of sound, from the beacon"),
    ),
    _derived(
        STATE, "where it is, what it does and how far it is from each limit; for each estimate",
        t=_T, state=text("region/substate, or the leg's path"), leg=text("empty if none"),
        since_s=number("s", "in this state"),
        mission_time_s=_maybe("s", "since the start"), digest=text("of the mission"),
        latitude_deg=_maybe("deg"), longitude_deg=_maybe("deg"), north_m=_maybe("m", "of home"),
        east_m=_maybe("m", "of home"), depth_m=_maybe("m"), altitude_m=_maybe("m"),
        heading_deg=_maybe("deg", "true"), speed_m_s=_maybe("m/s", "through the water"),
        current_north_m_s=_maybe("m/s"), current_east_m_s=_maybe("m/s"),
        radius_95_m=_maybe("m", "long half axis of the 95 % ellipse"),
        fix_age_s=_maybe("s"), nis=_maybe("", "normalised innovation squared, last update"),
        to_depth_m=_maybe("m", "left to the limit"), to_radius_m=_maybe("m", "left to the limit"),
        to_time_s=_maybe("s", "left to the limit"), to_voltage_v=_maybe("V", "left to the limit"),
        breached=listed(text("limit"), "limits that are breached"),
        commander=text("who commands, empty if nobody"),
    ),
    _known(POSITION, "the estimated position", LOCATION_FIX),
    _known(FIXES, "the fixes as places", LOCATION_FIX),
    _known(POSE, "position and attitude, metres from home", POSE_IN_FRAME),
    _known(JOURNAL, "what happened, in words", LOG),
    _known(PLAN, "the mission's places, lines and areas", GEO_JSON),
)  # fmt: skip

TOPICS: Mapping[str, Topic] = {topic.name: topic for topic in (*RAW, *DERIVED)}
