"""The engine: step(now, inputs) -> outputs. No IO, no clock, no threads.

engine     the order within a step                  core         engine state, and the actions on it
orders     which operator may ask for what, where   run, plan    a mission under way
vehicle_state   what can be believed                watch        what the limits look at
limits     the limits, a table of rows              monitor      which are breached, and how long
ascent     surfacing, proved by the depth           words        what stands in Steps and journals
variables  what guards can name                     guards       expressions over an estimate
machine    the chart as a `transitions` machine     bounds       the bounds in force
"""
