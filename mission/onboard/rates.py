"""The bit rate of each serial port: the rate in its URL, else that of its role.

    vehicle   the rate of its document, or the key ``baud`` of its vehicle file's ``wire``
    gps       9600 bit/s (NMEA 0183 receivers), gps2 as well
    sensors   9600 bit/s
    modem     115200 bit/s (document 000)

What does not live here: opening them (links), the rate of a vehicle (protocol.vehicles).
"""

from __future__ import annotations

from dataclasses import replace

from links import at_rate
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from protocol.modem import BAUD as MODEM_BAUD
from protocol.vehicles import line_rate

GPS_BAUD = 9600
SENSORS_BAUD = 9600


def rated(configuration: Configuration, vehicle: Vehicle) -> Configuration:
    """Return the configuration with a bit rate in the URL of each serial port."""
    links = configuration.links
    told = replace(
        links,
        vehicle=at_rate(links.vehicle, line_rate(vehicle.codec, vehicle.wire)),
        gps=None if links.gps is None else at_rate(links.gps, GPS_BAUD),
        gps2=None if links.gps2 is None else at_rate(links.gps2, GPS_BAUD),
        sensors=None if links.sensors is None else at_rate(links.sensors, SENSORS_BAUD),
        modem=None if links.modem is None else at_rate(links.modem, MODEM_BAUD),
    )
    return replace(configuration, links=told)
