"""Every state, every event: each configuration of the runtime, crossed with each event, under laws.

    configurations  x  events  ->  cells  ->  laws  ->  violations

Everything happens at the runtime: telemetry, fixes, acknowledgements and operators' commands are
bytes that go through the real decoders, and what a law sees is bytes that left, the Steps on
record, and the state. A board of documents 002 to 004 is heard and told in bytes of its own
(lines). Laws are written from the design and the rules alone: they never ask the engine what is
right. Three things reach behind the bytes, because a day would not do otherwise: a configuration is
put in place by the engine's ``place`` (leg, rounds, time in the leg), a distance that a leg waits
for is given to it (exit_inputs), and a runtime is copied whole (fork), so that each cell begins at
the same instant.

    wire            the sea, and what the AUV and the GPS say of it, in bytes
    lines           each vehicle's line: its reports, and what it is told in the words of the laws
    world           a runtime with a vehicle on its line, and what was seen of it
    fork            one runtime as many
    configurations  the ways into every configuration
    commands        events: the rows of what operators say
    limit_events    events that trip each limit
    events          the others: readings, answers, time, a restart
    exit_inputs     the event that a leg's exit waits for
    laws            the rows of laws: states; proof_laws what is proved, line_laws what leaves when,
                    leg_laws legs, operator_laws what is answered
    run             all of it, on several processes

What does not live here: flights (a cell lasts seconds), bit errors on the lines (protocol, links).
"""
