"""The one core of the sea and of the simulation: bytes in, bytes out, sans-IO.

drive      the whole                       topside, vessel, staging, nodes   the operator's side
frontseat  one frame at a time             repeater   for boards that answer nothing
records    what goes on record, and back
"""
