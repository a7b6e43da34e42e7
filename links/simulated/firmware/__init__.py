"""Firmware of the simulated boards: real bytes at the real rate, built on protocol/.

uart.py         line rate, bursts, splices
controllers.py  heading and depth hold
stm32.py        what both profiles share: @SD, power, rudders, manual mode, resets
documented.py   profile `documented`: exactly as in document 000
as_built.py     profile `as-built`: the board as it exists
gps.py          the GPS receiver on the Pi's own port
"""
