"""The engine: step(now, inputs) -> outputs. No IO, no clock, no threads.

engine     the order within a step, what an operator may ask
core       what is in its hands, and its verbs         run, plan    a mission under way
orders     who may ask for what, where                 guards       three-valued, `sure`, `held`
watch      what the limits need to know                senses       what can be believed
ascent     surfacing, proved by the depth              regions      what all missions share
"""
