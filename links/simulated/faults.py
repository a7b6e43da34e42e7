"""Faults of the simulated vehicle: one table, FAULTS. Each can be switched on for a while.

A row has a description, a default value and duration, and how the fault begins and ends. Faults
begin and end on control ticks (0.2 s). What does not live here: when (settings.FaultEvent), faults
of added sensors (added_faults), that ``WF`` does not last (the board is built like that).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import cos, radians, sin

from links.simulated.added_faults import ADDED_FAULTS
from links.simulated.fault import Fault, Parts
from links.simulated.firmware.stm32 import Mode
from links.simulated.plant import LEFT_MAIN, RIGHT_MAIN
from links.simulated.sensors import Health, Sensor
from links.simulated.wrong import Deaf, Drifting, Late, Stuck, Wrong

_ROLL, _HEADING, _DEPTH, _ALTITUDE = 0, 2, 4, 5  # places in the list of ``Sensors.sample``
_CURRENT, _BATTERY, _WEIGHT = "current", "battery", "weight"  # slots of faults

FLICKER = 0.8  # V


def _sensor(sensor: Sensor, health: Health) -> Fault:
    def begin(vehicle: Parts, _: float) -> None:
        vehicle.sensors.health[sensor] = health

    def end(vehicle: Parts, _: float) -> None:
        vehicle.sensors.health.pop(sensor, None)

    name = sensor.name.lower()
    says = f"{name} is {health.value.replace('_', ' ')}"
    return Fault(says, begin, end, slot=f"health of {name}")


def _bent(
    slot: int, says: str, value: float, unit: str, scale: float = 1.0, factor: float = 1.0
) -> Fault:
    """A constant error. ``scale`` converts the value to the sensor's unit."""

    def begin(vehicle: Parts, value: float) -> None:
        vehicle.sensors.bent[slot] = (factor, scale * value)

    def end(vehicle: Parts, _: float) -> None:
        vehicle.sensors.bent.pop(slot, None)

    return Fault(says, begin, end, value, unit, slot=f"bent {slot}")


def _wrong(
    slot: int, says: str, make: Callable[[float], Wrong], value: float, unit: str, scale: float
) -> Fault:
    def begin(vehicle: Parts, value: float) -> None:
        vehicle.sensors.wrong[slot] = make(scale * value)

    def end(vehicle: Parts, _: float) -> None:
        vehicle.sensors.wrong.pop(slot, None)

    return Fault(says, begin, end, value, unit, slot=f"wrong {slot}")


def _looks_well(
    name: str, slot: int, unit: str, noise: float, drift: float, scale: float = 1.0
) -> dict[str, Fault]:
    """Faults with plausible values: stuck with ``noise``, drifting by ``drift`` a second, late."""
    return {
        f"{name}_stuck": _wrong(slot, f"{name} is stuck, and noisy", Stuck, noise, unit, scale),
        f"{name}_drifting": _wrong(slot, f"{name} drifts", Drifting, drift, f"{unit}/s", scale),
        f"{name}_late": _wrong(slot, f"{name} comes late", Late, 10.0, "s", 1.0),
    }


def _line(name: str, says: str, value: float, unit: str) -> Fault:
    def begin(vehicle: Parts, value: float) -> None:
        setattr(vehicle.stm32.tx, name, value)

    def end(vehicle: Parts, _: float) -> None:
        setattr(vehicle.stm32.tx, name, 0.0)

    return Fault(says, begin, end, value, unit)


def _board(name: str, says: str, duration: float = 60.0) -> Fault:
    def begin(vehicle: Parts, _: float) -> None:
        setattr(vehicle.stm32, name, True)

    def end(vehicle: Parts, _: float) -> None:
        setattr(vehicle.stm32, name, False)

    return Fault(says, begin, end, duration=duration)


def _gps(name: str, says: str) -> Fault:
    def begin(vehicle: Parts, _: float) -> None:
        setattr(vehicle.gps, name, True)

    def end(vehicle: Parts, _: float) -> None:
        setattr(vehicle.gps, name, False)

    return Fault(says, begin, end)


def _weak(thrusters: tuple[int, ...], says: str, left: float = 0.4) -> Fault:
    """Weak thrusters. If several faults weaken one, the least remaining share counts."""

    def begin(vehicle: Parts, share: float) -> None:
        for thruster in thrusters:
            weak = vehicle.plant.weak[thruster]
            weak.append(share)
            vehicle.plant.weaken(thruster, min(weak))

    def end(vehicle: Parts, share: float) -> None:
        for thruster in thrusters:
            weak = vehicle.plant.weak[thruster]
            weak.remove(share)
            vehicle.plant.weaken(thruster, min(weak, default=1.0))

    return Fault(says, begin, end, left, "share left" if left else "", adds=True)


def _trim(sign: float, says: str) -> Fault:
    def begin(vehicle: Parts, newtons: float) -> None:
        vehicle.plant.buoyancy += sign * newtons

    def end(vehicle: Parts, newtons: float) -> None:
        vehicle.plant.buoyancy -= sign * newtons

    return Fault(says, begin, end, 8.0, "N", adds=True)


def _deaf(letter: str) -> Fault:
    def begin(vehicle: Parts, _: float) -> None:
        vehicle.stm32.ignores.add(letter)

    def end(vehicle: Parts, _: float) -> None:
        vehicle.stm32.ignores.discard(letter)

    return Fault(f"the board does not hear {letter}", begin, end)


def _refuse(vehicle: Parts, _: float) -> None:
    vehicle.stm32.refuses = "FHS"


def _accept(vehicle: Parts, _: float) -> None:
    vehicle.stm32.refuses = ""


def _dives(until: str, says: str, duration: float = 60.0) -> Fault:
    """The board dives at full power whatever it is sent; the code ``until`` ends this ("": none
    does). When the fault ends, a board that steers corrects the thrusters by itself; one in mode
    DEFAULT is set to rest here."""

    def begin(vehicle: Parts, _: float) -> None:
        vehicle.stm32.dives.append(until)

    def end(vehicle: Parts, _: float) -> None:
        board = vehicle.stm32
        if until in board.dives:
            board.dives.remove(until)
        if not board.dives and board.mode is Mode.DEFAULT and not board.hung:
            board.change(Mode.DEFAULT)

    return Fault(says, begin, end, duration=duration, adds=True)


def _capsize(vehicle: Parts, _: float) -> None:
    _list(vehicle, 180.0)


def _list(vehicle: Parts, degrees: float) -> None:
    righting, angle = vehicle.plant.body.righting, radians(degrees)
    vehicle.plant.load(righting * cos(angle), righting * sin(angle) if degrees < 180.0 else 0.0)


def _right(vehicle: Parts, _: float) -> None:
    vehicle.plant.load(vehicle.plant.body.righting)


def _slow(vehicle: Parts, seconds: float) -> None:
    vehicle.stm32.late = seconds


def _prompt(vehicle: Parts, _: float) -> None:
    vehicle.stm32.late = 0.0


def _busy(vehicle: Parts, seconds: float) -> None:
    vehicle.stm32.busy = seconds


def _idle(vehicle: Parts, _: float) -> None:
    vehicle.stm32.busy = 0.0


def _silence(vehicle: Parts, _: float) -> None:
    vehicle.stm32.tx.silent = True


def _speak(vehicle: Parts, _: float) -> None:
    vehicle.stm32.tx.silent = False


def _hang(vehicle: Parts, _: float) -> None:
    vehicle.stm32.hung = True


def _watchdog(vehicle: Parts, _: float) -> None:
    vehicle.stm32.restart()


def _brown_out(vehicle: Parts, _: float) -> None:
    vehicle.stm32.restart()
    vehicle.stm32.booting = True


def _booted(vehicle: Parts, _: float) -> None:
    vehicle.stm32.booting = False


def _splice_all(vehicle: Parts, _: float) -> None:
    vehicle.stm32.splice = 1.0


def _splice_usual(vehicle: Parts, _: float) -> None:
    vehicle.stm32.splice = vehicle.usual_splice


def _current_speed(vehicle: Parts, speed: float) -> None:
    direction = vehicle.sea.current[1]
    vehicle.current = (speed * cos(direction), speed * sin(direction))


def _current_turn(vehicle: Parts, degrees: float) -> None:
    speed, direction = vehicle.sea.current
    turned = direction + radians(degrees)
    vehicle.current = (speed * cos(turned), speed * sin(turned))


def _current_usual(vehicle: Parts, _: float) -> None:
    speed, direction = vehicle.sea.current
    vehicle.current = (speed * cos(direction), speed * sin(direction))


def _garble(vehicle: Parts, share: float) -> None:
    vehicle.stm32.garbles = share


def _understand(vehicle: Parts, _: float) -> None:
    vehicle.stm32.garbles = 0.0


def _gps_garbled(vehicle: Parts, share: float) -> None:
    vehicle.gps.corrupt = share


def _gps_clear(vehicle: Parts, _: float) -> None:
    vehicle.gps.corrupt = 0.0


def _gps_jump(vehicle: Parts, metres: float) -> None:
    vehicle.gps.offset = (metres, 0.0)


def _gps_true(vehicle: Parts, _: float) -> None:
    vehicle.gps.offset = (0.0, 0.0)


def _battery(vehicle: Parts, volts: float) -> None:
    vehicle.sensors.battery_override, vehicle.sensors.battery_noise = volts, 0.0


def _battery_flickers(vehicle: Parts, volts: float) -> None:
    vehicle.sensors.battery_override, vehicle.sensors.battery_noise = volts, FLICKER


def _battery_usual(vehicle: Parts, _: float) -> None:
    vehicle.sensors.battery_override, vehicle.sensors.battery_noise = None, 0.0


def _gps_in_turn(vehicle: Parts, places: float) -> None:
    vehicle.gps.in_turn = max(int(places), 1)


def _gps_in_order(vehicle: Parts, _: float) -> None:
    vehicle.gps.in_turn = 0


FAULTS: dict[str, Fault] = {
    **{
        f"{sensor.name.lower()}_{health.value}": _sensor(sensor, health)
        for sensor in Sensor
        for health in Health
        if health is not Health.HEALTHY
    },
    "heading_mirrored": _bent(_HEADING, "the compass turns the wrong way", 0.0, "", factor=-1.0),
    "heading_off": _bent(_HEADING, "the compass came loose", 60.0, "deg", radians(1.0)),
    "attitude_off": _bent(_ROLL, "the roll reads more", 120.0, "deg", radians(1.0)),
    "altitude_off": _bent(_ALTITUDE, "altitudes read more", 2.0, "m"),
    **_looks_well("roll", _ROLL, "deg", 0.5, 0.5, radians(1.0)),
    **_looks_well("heading", _HEADING, "deg", 1.0, 0.5, radians(1.0)),
    **_looks_well("depth", _DEPTH, "m", 0.05, -0.1),
    **_looks_well("altitude", _ALTITUDE, "m", 0.05, 0.1),
    "depth_too_deep": _bent(_DEPTH, "depths read more", 1.0, "m"),
    "depth_too_shallow": _bent(_DEPTH, "depths read less", 1.0, "m", -1.0),
    "depth_dead": _wrong(_DEPTH, "the depth says 0, whatever is true", Deaf, 0.0, "", 1.0),
    "altitude_rings": _wrong(
        _ALTITUDE, "the altimeter hears its own pulse", partial(Deaf, noise=0.05), 0.6, "m", 1.0
    ),
    "stm32_silent": Fault("the board is heard no more, and goes on", _silence, _speak, duration=10),
    "stm32_hang": Fault(
        "the board hangs with its thrusters on, until the watchdog", _hang, _watchdog, duration=8
    ),
    "stm32_restart": Fault(
        "brown-out: everything neutral and forgotten", _brown_out, _booted, duration=3
    ),
    "ack_lost": _board("loses_acks", "commands are obeyed, and not answered", 5.0),
    "command_lost": _board("deaf", "commands do not arrive", 5.0),
    "command_corrupted": Fault(
        "a bit turned over in a command", _garble, _understand, 0.3, "share of bursts", 20.0
    ),
    "bytes_corrupted": _line("corrupt", "a bit turned over in a frame", 0.3, "share of frames"),
    "line_noise": _line("noise", "garbage in front of a frame", 0.3, "share of frames"),
    "splice": Fault("every answer that can, lands in an @SD", _splice_all, _splice_usual),
    "gps_lost": _gps("blind", "the receiver has no fix"),
    "gps_silent": _gps("silent", "the receiver sends nothing"),
    "gps_stuck": _gps("stuck", "the receiver repeats its last fix, under water too"),
    "gps_in_turn": Fault(
        "the receiver says its last places in turn, under water too",
        _gps_in_turn,
        _gps_in_order,
        3.0,
        "places",
    ),
    "gps_wanders": _gps("wanders", "the receiver says plausible places under water, too"),
    "gps_corrupted": Fault(
        "a bit turned over in its sentences", _gps_garbled, _gps_clear, 0.5, "share of seconds"
    ),
    "gps_jump": Fault("fixes are beside the truth, northward", _gps_jump, _gps_true, 200.0, "m"),
    "left_main_weak": _weak((LEFT_MAIN,), "the left main thruster is weak"),
    "right_main_weak": _weak((RIGHT_MAIN,), "the right main thruster is weak"),
    "verticals_weak": _weak((2, 3, 4), "the vertical thrusters are weak"),
    "mains_dead": _weak((LEFT_MAIN, RIGHT_MAIN), "no main thruster turns", 0.0),
    "verticals_dead": _weak((2, 3, 4), "no vertical thruster turns", 0.0),
    "heavy": _trim(-1.0, "less buoyancy"),
    "light": _trim(1.0, "more buoyancy"),
    "current_speed": Fault(
        "another current, same direction", _current_speed, _current_usual, 0.8, "m/s", slot=_CURRENT
    ),
    "current_turn": Fault(
        "the current turns", _current_turn, _current_usual, 90.0, "deg", slot=_CURRENT
    ),
    "battery_low": Fault("low control battery", _battery, _battery_usual, 9.0, "V", slot=_BATTERY),
    "battery_flickers": Fault(
        "a noisy control battery, about", _battery_flickers, _battery_usual, 9.0, "V", slot=_BATTERY
    ),
    "unexplained_dive": _dives("", "it dives at full power, nobody said so", 20.0),
    **{f"deaf_to_{letter.lower()}": _deaf(letter) for letter in "WUXFHS"},
    "refuses": Fault("sets are answered N", _refuse, _accept),
    "dives_until_up": _dives("U", "it dives at full power until it hears U"),
    "dives_until_stop": _dives("X", "it dives at full power until it hears X"),
    "obeys_late": Fault("commands are obeyed late", _slow, _prompt, 1.0, "s"),
    "busy": Fault("the board hears nothing behind a word, for", _busy, _idle, 0.5, "s", 60.0),
    "thrust_dead": _board("powerless", "words are answered, and no thruster turns"),
    "capsized": Fault("it turns upside down", _capsize, _right, slot=_WEIGHT),
    "listing": Fault(
        "weight that shifted holds it at a roll", _list, _right, 120.0, "deg", slot=_WEIGHT
    ),
    **ADDED_FAULTS,
}
