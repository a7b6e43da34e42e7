"""Campaigns: many seeded flights that try to prove the project wrong.

    draw --Plan--> trial (the lock-step flight that is disturbed) --Trace--> laws, audit
                                                                       |
    faults, proofs (one flight each) --> pool --> totals    soak: missions in a row for days

    draw          what goes wrong in a flight of the fault campaign, by seed and number
    search        what is flown next, by how near flights came (margins)
    steered       a flight by its name
    noticing      flights with a safety rule broken (broken), where that matters (reached)
    disturbances  what operators, their links and the program may do: INCIDENTS, a table
    onboard       the runtime on the flight's clock; it can be killed and begun anew from its store
    laws          lost, overrun: what may not come of a flight
    excuses       what physics, an order or a rule makes of a flight
    audit         spurious: a byte to the vehicle that nothing asked for
    calm          flights without any fault: what a limit ends is a false alarm
    generated     random valid missions, by seed
    proofs        flights within what the check assumed, against what it proved

What does not live here: how a flight goes (flight), what can go wrong with the vehicle
(links.simulated.faults), what is proved (check).
"""
