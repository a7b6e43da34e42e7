"""Every state, every event: each configuration of the runtime, crossed with each event, under laws.

    configurations  x  events  ->  cells  ->  laws  ->  violations

All input is bytes into the runtime: telemetry, fixes, acknowledgements and operators' commands go
through the real decoders. A law sees the bytes that left, the recorded Steps and the state. A board
of documents 002 to 004 sends and receives its own bytes (lines). Laws are written from the design
and the rules alone: they never ask the engine what is right. Three things bypass the bytes, since
the proof would otherwise take more than a day: the engine's ``place`` sets up a configuration (leg,
rounds, time in the leg), a leg that waits for a distance is given it (exit_inputs), and a runtime
is copied whole (fork), so that each cell begins at the same instant.

    wire            the sea, and the bytes in which the AUV and the GPS report it
    lines           each vehicle's line: its reports, and its frames as the commands of the laws
    world           a runtime with a vehicle on its line, and what was seen of it
    fork            copies of one runtime
    configurations  the ways into every configuration
    commands        events: what operators send
    limit_events    events that trip each limit
    events          the others: readings, answers, time, a restart; and the table of all
    exit_inputs     the event that a leg's exit waits for
    laws            the rows of laws: states; proof_laws what is proved, line_laws what leaves when,
                    leg_laws legs, operator_laws what is answered
    run             all of it, on several processes

What does not live here: flights (a cell lasts seconds), bit errors on the lines (protocol, links).
"""
