"""A simulated vehicle: to the engine it is a link. It keeps its own physics and its own geodesy.

settings.py   the sea, sensor errors, faults to come; --set texts
plant.py      6-DOF dynamics       geodesy.py  where that is on the globe
sensors.py    noise, bias, health  faults.py   what can go wrong: FAULTS
firmware/     STM32 (two profiles) and GPS, real bytes
link.py       all of it on one clock: SimulatedVehicle
pty.py        the same in real time on two pseudo-terminals
"""
