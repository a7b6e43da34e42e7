"""The checks of `doctor` before a dive: of the Pi, the vehicle file and the vehicle's ports."""
