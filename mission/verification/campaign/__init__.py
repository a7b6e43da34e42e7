"""Campaigns: many seeded flights that try to prove the project wrong.

    draw --Plan--> trial (the lock-step flight that is disturbed) --Trial--> laws, audit
                                                                       |
    faults, proofs (one flight each) --> pool --> totals    soak: missions in a row for days

    draw          what goes wrong in a flight of the fault campaign, by seed and number
    disturbances  what operators, their links and the program may do: INCIDENTS, a table
    onboard       the runtime on the flight's clock; it can be killed and begun anew from its store
    laws          lost, overrun: what may not come of a flight
    audit         spurious: a byte to the vehicle that nothing asked for
    generated     random valid missions, by seed
    proofs        flights within what the check assumed, against what it proved

What does not live here: how a flight goes (flight), what can go wrong with the vehicle
(links.simulated.faults), what is proved (check).
"""
