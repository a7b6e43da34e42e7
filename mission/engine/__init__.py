"""The engine: step(now, inputs) -> outputs. No IO, no clock, no threads.

engine     the order within a step                  core         what is in its hands, its verbs
orders     which operator may ask for what, where   run, plan    a mission under way
senses     what can be believed                     watch        what the limits need to know
ascent     surfacing, proved by the depth       words        what stands in Steps and journals
"""
