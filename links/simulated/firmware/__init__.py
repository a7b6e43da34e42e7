"""Firmware of the simulated boards: real bytes at the real pace, built on protocol/.

uart.py         pace, bursts, splices
controllers.py  heading and depth hold
stm32.py        what both profiles share: @SD, power, rudders, manual mode, resets
documented.py   profile `documented`: document 000 to the letter
as_built.py     profile `as-built`: the board that exists
gps.py          the receiver on the Pi's own port
"""
