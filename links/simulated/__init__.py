"""Simulated vehicles. The engine sees each as a link. Physics and geodesy are their own.

settings.py   the sea, sensor errors, planned faults; --set texts
plant.py      6-DOF dynamics       geodesy.py  positions on the globe
sensors.py    noise, bias, health  faults.py   what can go wrong: FAULTS
firmware/     STM32 (two profiles) and GPS, real bytes
link.py       all of these on one clock: SimulatedVehicle
pty.py        the same in real time on two pseudo-terminals
"""
