"""Turn a setting with its amount, or a ZA command, into Settings of the model.

What does not live here: which settings go together, and with which leg (legs.py).
"""

from __future__ import annotations

import math

from mission.authoring.language.clauses import Amount, Name
from mission.authoring.language.values import Values
from mission.authoring.language.wire import wire_complaint
from mission.authoring.language.words import ATTITUDE, SETTINGS, ZA, SettingRow
from mission.model import Setting, Where
from mission.model.units import GEARS, compass, number_text
from mission.model.vehicle import VehicleError


class Settings:
    """Reads the settings of one file; errors go to the problems."""

    def __init__(self, values: Values) -> None:
        self._values, self._problems = values, values.problems

    def said(self, row: SettingRow, amount: Amount, where: Where) -> list[Setting]:
        if row.gear:
            gear = self._values.whole(amount, int(row.low), int(row.high), row.word)
            return [Setting(row.field, row.sign * gear / GEARS + 0.0, where)]
        if row.word == "heading" and amount.text.startswith("-") and amount.unit in ("", "deg"):
            told = number_text(float(amount.text) % 360)
            hint = f"write heading {told}; the wire's ZAH{amount.text} is heading "
            hint += number_text(-float(amount.text) % 360)
            message = "a compass says 0 to 360"
            self._problems.add("compass", amount.where, message, hint)
            return []
        value = self._values.number(amount, row.unit, row.low, row.high)
        if math.isnan(value):
            return []
        if row.word == "speed":
            return self._speed(value, amount, where)
        if row.field == "heading":
            value = value if value < math.tau else 0.0
        return [Setting(row.field, value, where)]

    def _speed(self, speed: float, amount: Amount, where: Where) -> list[Setting]:
        vehicle = self._values.vehicle
        if isinstance(vehicle, VehicleError):
            hint = "write a gear instead, or mend the vehicle file"
            self._problems.add("vehicle-file", amount.where, vehicle.brief, hint)
            return []
        curve = vehicle.speed_by_gear
        if speed > max(curve.y) * (1 + 1e-9):
            message = f"{vehicle.name} cannot go {number_text(speed)} m/s"
            fastest = number_text(max(curve.y))
            gear = math.ceil(curve.inverse(max(curve.y)))
            hint = f"its fastest is {fastest} m/s with gear {gear}"
            self._problems.add("too-fast", amount.where, message, hint)
            return []
        gear = vehicle.gear_near(speed)
        if gear == 0 and speed > 0:
            message = f"{number_text(speed)} m/s is nearest to standing still"
            hint = f"gear 1 makes {number_text(curve.at(1))} m/s"
            self._problems.add("too-slow", amount.where, message, hint)
        return [Setting("surge", gear / GEARS, where)]

    def wire(self, word: Name) -> list[Setting]:
        complaint = wire_complaint(word.text)
        if complaint is not None:
            rule, message, hint = complaint
            self._problems.add(rule, word.where, message, hint)
            return []
        code, digits = word.text[2], word.text[3:]
        if code == ATTITUDE:
            pitch, roll = (Amount(text, "", word.where) for text in digits.split(";"))
            return [
                *self.said(SETTINGS["pitch"], pitch, word.where),
                *self.said(SETTINGS["roll"], roll, word.where),
            ]
        row, value = ZA[code], int(digits)
        if row.word == "heading":
            return [Setting("heading", compass(row.sign * value), word.where)]
        setting = SETTINGS[row.word]
        amount = row.sign * setting.sign * value
        scaled = amount / GEARS if setting.gear else float(amount)
        return [Setting(setting.field, scaled + 0.0, word.where)]
