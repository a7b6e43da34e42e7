"""The position estimate and its uncertainty: dead reckoning, fixes, and the health of sensors.

    Telemetry, Fix -> health (is each reading to be believed?) -> filter -> Estimate

This is the only package that imports filterpy, and only the part that it uses (``kalman``).
Importing the package does not import filterpy; building a Navigation does. The results are
deterministic to the last bit: time is an input, and there is no clock and no thread.

What does not live here: what the engine does about an invalid reading, guards, the wire.
"""

from mission.navigation.geodesy import LocalFrame
from mission.navigation.navigator import Navigation

__all__ = ["LocalFrame", "Navigation"]
