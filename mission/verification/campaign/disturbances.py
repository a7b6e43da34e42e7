"""What goes wrong outside the vehicle: operators, their links, the program, its disk. A table.

An incident is drawn as disturbances, each at its time: bytes that somebody sends, a connection that
comes or goes, the program killed and restarted, a cable pulled. Times are s from the beginning of
the incident.

What does not live here: faults of the vehicle (links.simulated.faults), when an incident begins
(draw), how a disturbance is done (trial).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random

from mission.verification.rig.acts import BOAT, MODEM, OTHER_BOAT, PORT, TOPSIDE, Act, Disturbance
from protocol.messages import (
    ClearMission,
    DataQuery,
    Emergency,
    MissionLine,
    NodeSwitch,
    Order,
    SetSafety,
    SetTime,
    StartMission,
)
from protocol.modem import Sender, wrap
from protocol.operator_words import WORDS
from protocol.topside import encode

STICK_EVERY = 0.2  # s (R1: while the stick is held)
STICK_ENDS = b"@MMF0$"  # twice (R1)
SLIDER_RATES = (5, 20, 60, 200)  # commands a second
SLIDER = 15.0  # s at most that a slider moves
LATE = 120.0  # s that a copy may be late (R12)
STALL = 8.0  # s at most: the watchdog kills a program that stalls longer


@dataclass(frozen=True, slots=True)
class Incident:
    """``draw`` gets the lines of another mission than the one that flies."""

    says: str
    draw: Callable[[Random, tuple[str, ...]], list[Disturbance]]


def _say(after: float, data: bytes, link: str = TOPSIDE, address: str = BOAT) -> Disturbance:
    return Disturbance(after, Act.SAY, data, link, address)


def _once(*frames: bytes) -> Callable[[Random, tuple[str, ...]], list[Disturbance]]:
    return lambda rng, lines: [_say(0.0, frame) for frame in frames]


def _stick(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """Held for a while, then let go."""
    held = rng.uniform(0.5, 15.0)
    frame = rng.choice(
        [
            b"@MM%c%d$" % (rng.choice(b"FBUD"), rng.randint(1, 12)),
            b"@MR%c%d$" % (rng.choice(b"LRFBUD"), rng.randint(1, 5)),
            b"@MS%d,%d$" % (rng.randint(1, 120), rng.randint(-180, 180)),
            b"@MP%d,%d$" % (rng.randint(1, 120), rng.randint(-180, 180)),
            b"@MT%d,%d$" % (rng.randint(1, 5), rng.randint(-12, 12)),
        ]
    )
    count = int(held / STICK_EVERY)
    moves = [_say(i * STICK_EVERY, frame) for i in range(count)]
    return [*moves, *(_say((count + i) * STICK_EVERY, STICK_ENDS) for i in range(2))]


def _stick_and_resume(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    moves = _stick(rng, lines)
    return [*moves, _say(moves[-1].after + rng.uniform(0.5, 50.0), encode(StartMission()))]


def _stick_lost(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    """The boat goes out of range with the stick held: no neutral M, no orderly end."""
    moves = _stick(rng, lines)[:-2]
    gone = moves[-1].after + 0.1 if moves else 0.1
    return [
        *moves,
        Disturbance(gone, Act.PART),
        Disturbance(gone + rng.uniform(5.0, 200.0), Act.JOIN),
    ]


def _stop_and_clear(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    stop, clear = encode(Emergency(Order.STOP)), encode(ClearMission())
    return [_say(0.0, stop), _say(rng.uniform(0.0, 60.0), clear)]


def _stop_then_surface(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    orders = [encode(Emergency(order)) for order in (Order.STOP, Order.SURFACE)]
    rng.shuffle(orders)
    return [_say(0.0, orders[0]), _say(rng.uniform(0.0, 20.0), orders[1])]


def _upload(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    """Another mission, or a part of it, is uploaded at any time."""
    sent = lines[: rng.randint(1, len(lines))]
    frames = [encode(MissionLine(len(lines), i, line)) for i, line in enumerate(sent, 1)]
    return [_say(0.1 * i, frame) for i, frame in enumerate(frames)]


def _limits(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    limits = SetSafety(
        radius=rng.choice([None, round(rng.uniform(30.0, 300.0))]),
        time=rng.choice([None, 60.0 * rng.randint(2, 20)]),
        depth=rng.choice([None, float(rng.randint(2, 20))]),
        voltage=rng.choice([None, 11.0]),
    )
    return [_say(0.0, encode(limits))]


def _auto_closed(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    closed, opened = (encode(NodeSwitch(s)) for s in ("OOOCCC", "OOOCCO"))
    return [_say(0.0, closed), _say(rng.uniform(1.0, 60.0), opened)]


def _relays(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    letters = bytes(rng.choice(b"OC") for _ in range(7))
    frames = [b"@RI$", b"@RS%b$" % letters, b"@DS%d,%d$" % (rng.randint(1, 2), 10), b"@DA1,-2$"]
    return [_say(rng.uniform(0.0, 5.0), rng.choice(frames)) for _ in range(rng.randint(1, 8))]


def _slider(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """A slider moves rudders, lights or thrusters, at times faster than the line carries."""
    rate, seconds = rng.choice(SLIDER_RATES), rng.uniform(2.0, SLIDER)
    angles = [b"@DS%d,%d$" % (rng.randint(1, 3), angle) for angle in range(-15, 23)]
    others = [b"@DA1,1$", b"@DA2,-1$", b"@DS3,5$", b"@RI$", b"@RSOOOOOOC$", b"@DU$"]
    words = rng.choice([angles, others])
    return [_say(i / rate, rng.choice(words)) for i in range(int(rate * seconds))]


def _late_copies(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    """Commands of the boat arrive by modem as well, once or twice, up to two minutes later. Other
    commands are sent in between."""
    words = [
        *(encode(StartMission()), encode(StartMission()), encode(ClearMission())),
        *(encode(SetSafety(depth=d)) for d in (2000.0, 5.0)),
        *(encode(NodeSwitch(s)) for s in ("OOOCCC", "OOOCCO")),
        encode(MissionLine(len(lines), 1, lines[0])),
        b"@RSOOOOOOO$",
    ]
    disturbances = []
    for word in rng.sample(words, rng.randint(1, 4)):
        said = rng.uniform(0.0, 20.0)
        late = [said + rng.uniform(0.0, LATE) for _ in range(rng.randint(1, 2))]
        disturbances.append(_say(said, word))
        disturbances += [_say(t, wrap(word, Sender.TOPSIDE), MODEM, "") for t in late]
    return disturbances


def _modem_drips(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """A false frame head, then single bytes of noise for minutes, and an order in between."""
    every, count = rng.uniform(0.03, 0.95), rng.randint(20, 300)
    head = b"#\x02" + rng.randint(1, 3200).to_bytes(2, "little") + b"\x01"
    drips = [_say(i * every, rng.randbytes(1), MODEM, "") for i in range(1, count)]
    order = wrap(rng.choice([b"@ZAX0$", b"@ZAWF$", b"@DU$"]), Sender.TOPSIDE)
    ordered = _say(rng.uniform(0.0, count * every), order, MODEM, "")
    return [_say(0.0, head, MODEM, ""), *drips, ordered]


def _lost(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    return [Disturbance(0.0, Act.PART), Disturbance(rng.uniform(1.0, 300.0), Act.JOIN)]


def _flood(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    frames = [encode(DataQuery()), b"@RI$", b"@NI$", encode(StartMission()), b"@AQ$"]
    return [_say(0.01 * i, rng.choice(frames) * rng.randint(1, 20)) for i in range(100)]


def _garbage(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    pieces = rng.randint(1, 10)
    return [_say(0.3 * i, rng.randbytes(rng.randint(1, 400))) for i in range(pieces)]


def _near_frames(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    """Good frames with a byte changed, cut or doubled."""
    good = [b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@MMF10$", b"@MS120,-90$", b"@SP,1000,5,200,10,$",
            encode(MissionLine(2, 1, lines[0]))]  # fmt: skip
    disturbances = []
    for i in range(rng.randint(1, 20)):
        frame = bytearray(rng.choice(good))
        at = rng.randrange(len(frame))
        match rng.randrange(3):
            case 0:
                frame[at] = rng.randrange(256)
            case 1:
                del frame[at:]
            case _:
                frame[at:at] = frame[at : at + 1]
        disturbances.append(_say(rng.uniform(0.0, 10.0) + i * 0.001, bytes(frame)))
    return disturbances


def _other_boat(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """A second connection tries to command as well."""
    words = [b"@AA$", b"@AC$", b"@ZAWF$", b"@ZAX0$", b"@MMF5$", b"@RI$", b"@DU$", b"@NSOOOCCO$"]
    said = [
        _say(rng.uniform(0.1, 30.0), rng.choice(words), TOPSIDE, OTHER_BOAT)
        for _ in range(rng.randint(1, 5))
    ]
    joins = Disturbance(0.0, Act.JOIN, b"", TOPSIDE, OTHER_BOAT)
    parts = Disturbance(rng.uniform(30.0, 60.0), Act.PART, b"", TOPSIDE, OTHER_BOAT)
    return [joins, *said, parts]


def _by_modem(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    word = rng.choice([b"@ZAX0$", b"@ZAWF$", b"@DU$", b"@AQ$", b"@AA$", b"@MMD9$", b"@RI$"])
    times = [0.0, rng.uniform(3.0, 8.0)][: rng.randint(1, 2)]
    return [_say(t, wrap(word, Sender.TOPSIDE), MODEM, "") for t in times]


def _modem_garbled(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """Envelopes with flipped bits, cut short, or run together."""
    words = [b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@AC$", b"@DU$", b"@MMD9$"]
    said = []
    for i in range(rng.randint(1, 10)):
        data = bytearray(wrap(rng.choice(words), Sender.TOPSIDE))
        if rng.random() < 0.8:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        if rng.random() < 0.3:
            del data[rng.randrange(len(data)) :]
        said.append(_say(i * rng.uniform(0.2, 3.0), bytes(data), MODEM, ""))
    return said


def _stress(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    """Many commands of every kind, fast and in no order."""
    words = [
        *(b"@ZAX0$", b"@ZAWF$", b"@ZAX0$", b"@ZAWF$", b"@AA$", b"@AA$", b"@AC$", b"@AB$"),
        *(b"@MMU12$", b"@MMD12$", b"@MMF0$", b"@MRL5$", b"@MT3,-12$", b"@NSOOOCCC$"),
        *(b"@NSOOOCCO$", b"@SP,100,5,5,10,$", b"@SP,2000,240,100,10,$", b"@DU$", b"@AQ$"),
        *(b"@NI$", b"@RI$", b"@DS1,22$", b"@ST,2024/02/30 10:00:00,$"),
        encode(MissionLine(len(lines), 1, lines[0])),
    ]
    words += _others(words)
    t, disturbances = 0.0, []
    for _i in range(rng.randint(5, 60)):
        disturbances.append(_say(t, rng.choice(words)))
        t += rng.expovariate(1.0 / rng.choice([0.05, 0.5, 3.0]))
    return disturbances


def _others(said: Sequence[bytes]) -> list[bytes]:
    """Return the examples of all operator commands not in ``said``: new ones count, too."""
    codes = {frame[1:3] for frame in said}
    more = (word.examples for word in WORDS.values() if word.code.encode() not in codes)
    return list(itertools.chain.from_iterable(more))


def _nodes(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """Nodes are closed and opened at random, and set back at the end."""
    switched = [
        _say(rng.uniform(0.0, 60.0), b"@NSO%b$" % bytes(rng.choice(b"OC") for _ in range(5)))
        for _ in range(rng.randint(1, 4))
    ]
    return [*switched, _say(61.0, b"@NSOOOCCO$")]


def _crowd(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """Connections that come, send something or nothing, and go."""
    words = [b"", b"@DU$", b"@AQ$", b"@AA$", b"@A", b"\xff" * 300]
    disturbances = []
    for i in range(rng.randint(10, 60)):
        name, t = f"boat {i}", rng.uniform(0.0, 20.0)
        disturbances.append(Disturbance(t, Act.JOIN, b"", TOPSIDE, name))
        disturbances.append(_say(t + 0.1, rng.choice(words), TOPSIDE, name))
        if rng.random() < 0.7:
            disturbances.append(
                Disturbance(t + rng.uniform(0.2, 20.0), Act.PART, b"", TOPSIDE, name)
            )
    return disturbances


def _killed(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """The service manager restarts the program a few seconds later; the boat connects again."""
    back = rng.uniform(1.0, 8.0)
    return [
        Disturbance(0.0, Act.KILL),
        Disturbance(back, Act.BOOT),
        Disturbance(back + rng.uniform(0.1, 5.0), Act.JOIN),
    ]


def _killed_twice(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    again = rng.uniform(8.5, 40.0)
    second = [Disturbance(again + d.after, d.act) for d in _killed(rng, lines)]
    return [*(d for d in _killed(rng, lines) if d.after < again), *second]


def _ended(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """The program gets a SIGTERM, sometimes a second one before the vehicle is up."""
    hurry = [Disturbance(rng.uniform(0.0, 60.0), Act.HURRY)] if rng.random() < 0.3 else []
    return [Disturbance(0.0, Act.END), *hurry]


def _killed_in_a_write(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """The program dies in the next write of its store; the trial restarts it."""
    return [Disturbance(0.0, rng.choice([Act.DIE_BEFORE, Act.DIE_AFTER]))]


def _power_cut(rng: Random, lines: tuple[str, ...]) -> list[Disturbance]:
    return [Disturbance(0.0, Act.POWER), *_killed(rng, lines)]


def _stalled(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """The process stalls (swapping, a slow disk); then it reads all bytes in one piece."""
    return [Disturbance(0.0, Act.STALL), Disturbance(rng.uniform(0.2, STALL), Act.RUN)]


def _stalled_often(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    disturbances, t = [], 0.0
    for _i in range(rng.randint(3, 20)):
        disturbances += [
            Disturbance(t, Act.STALL),
            Disturbance(t + rng.uniform(0.05, 1.0), Act.RUN),
        ]
        t = disturbances[-1].after + rng.uniform(0.1, 3.0)
    return disturbances


def _wrong_device(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    """The GPS, a modem or a console on the port of the STM32 for a while."""
    pieces = [
        b"$GPGGA,080000.00,3017.247570,N,12009.214590,E,1,09,1.0,0.3,M,0.0,M,,*5B\r\n",
        wrap(b"@DU$", Sender.TOPSIDE),
        b"raspberrypi login: ",
        b"@ACK_ZAY$",
        b"@SD",
    ]
    said = [
        Disturbance(1.0 * i, Act.SAY, rng.choice(pieces), PORT, "")
        for i in range(rng.randint(1, 40))
    ]
    return [Disturbance(0.0, Act.UNPLUG), *said, Disturbance(said[-1].after + 1.0, Act.PLUG)]


def _unplugged(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    return [Disturbance(0.0, Act.UNPLUG), Disturbance(rng.uniform(0.5, 30.0), Act.PLUG)]


def _disk_full(rng: Random, _: tuple[str, ...]) -> list[Disturbance]:
    return [Disturbance(0.0, Act.FILL), Disturbance(rng.uniform(5.0, 300.0), Act.FREE)]


INCIDENTS: dict[str, Incident] = {
    "operator_stops": Incident("X", _once(encode(Emergency(Order.STOP)))),
    "operator_surfaces": Incident("W", _once(encode(Emergency(Order.SURFACE)))),
    "operator_stops_and_clears": Incident("X, later @AC", _stop_and_clear),
    "operator_stops_and_surfaces": Incident("X and W, one after the other", _stop_then_surface),
    "operator_starts_again": Incident("@AA once more", _once(encode(StartMission()))),
    "operator_clears": Incident("@AC, whatever is going on", _once(encode(ClearMission()))),
    "operator_sets_the_clock": Incident("@ST", _once(encode(SetTime("2031-02-03T04:05:06")))),
    "operator_under_stress": Incident("everything at once, in no order", _stress),
    "nodes_switched": Incident("@NS with any letters", _nodes),
    "stick": Incident("the stick is held for a while", _stick),
    "stick_and_resume": Incident("the stick, then @AA", _stick_and_resume),
    "stick_lost": Incident("the link is lost with the stick held", _stick_lost),
    "second_upload": Incident("another mission is sent", _upload),
    "limits_tightened": Incident("@SP with tighter limits", _limits),
    "auto_closed": Incident("@NS closes AUTO for a while", _auto_closed),
    "relays": Incident("@RS, @RI and rudders", _relays),
    "slider": Incident("rudders or power, up to 200 words a second", _slider),
    "late_copies": Incident("commands come by modem once more, up to 2 min late", _late_copies),
    "modem_drips": Incident("a false head, and noise at the pace of bytes", _modem_drips),
    "topside_lost": Incident("the boat's connection is gone for a while", _lost),
    "topside_floods": Incident("a thousand frames in a second", _flood),
    "crowd": Incident("many connections come and go", _crowd),
    "topside_garbage": Incident("bytes that are no frames", _garbage),
    "topside_near_frames": Incident("frames with a byte changed, cut, doubled", _near_frames),
    "other_boat": Incident("a second connection gives commands", _other_boat),
    "by_modem": Incident("commands by the acoustic modem", _by_modem),
    "modem_garbled": Incident("envelopes of the modem that are damaged", _modem_garbled),
    "killed": Incident("the program is killed and begun anew", _killed),
    "killed_twice": Incident("twice within a minute", _killed_twice),
    "ended": Incident("the program is ended in order, and begun anew", _ended),
    "killed_in_a_write": Incident("killed while it makes something durable", _killed_in_a_write),
    "power_cut": Incident("Pi and STM32 lose their power, and have it again", _power_cut),
    "stalled": Incident("the program stands still for seconds", _stalled),
    "stalled_often": Incident("again and again, for a moment", _stalled_often),
    "unplugged": Incident("the serial cable is pulled for a while", _unplugged),
    "wrong_device": Incident("something else is on the port of the STM32", _wrong_device),
    "disk_full": Incident("nothing can be made durable for a while", _disk_full),
}
