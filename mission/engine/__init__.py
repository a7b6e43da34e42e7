"""The engine: step(now, inputs) -> outputs. No IO, no clock, no threads.

engine     the order within a step                  state, core  the state, and actions on it
orders     operators' commands, and when allowed    run, plan    a mission under way
vehicle_state   reports, and whether to believe     watch        the quantities that limits check
limits     the limits, a table of rows              monitor      breached limits, and how long
ascent     surfacing, proved by the depth           words        texts of Steps and journals
variables  the names that guards can use            guards       conditions over readings
machine    the chart as a `transitions` machine     bounds       the bounds in force
"""
