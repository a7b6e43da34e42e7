"""Where the vehicle is, and how sure that is: dead reckoning, fixes, and the health of sensors.

    Telemetry, Fix -> health (is each reading to be believed?) -> filter -> Estimate

The only room that imports filterpy, of that what it uses alone (``kalman``); importing the package
does not, building a Navigation does. Deterministic to the last bit: time is an input, there is no
clock and no thread.

What does not live here: what the engine does about an invalid reading, guards, the wire.
"""

from mission.navigation.geodesy import LocalFrame
from mission.navigation.navigator import Navigation

__all__ = ["LocalFrame", "Navigation"]
