"""Campaigns: many seeded flights that try to prove the project wrong.

    draw --Plan--> trial (the disturbed flight in lock step) --Trace--> laws, audit
                                                                       |
    faults, proofs (one flight each) --> workers --> totals    soak: missions in a row for days

    draw          what goes wrong in a flight of the fault campaign, by seed and number
    search        which flights come next, by how near earlier ones came to breaking a law (margins)
    steered       a flight by its name
    noticing      flights with a safety rule broken (broken), where the rule matters (reached)
    disturbances  what operators, their links and the program may do: the table INCIDENTS
    laws          lost, overrun: outcomes that a flight must not have
    excuses       outcomes that physics, an order or a rule explains
    audit         spurious: a byte to the vehicle that nothing asked for
    calm          flights without any fault: a limit that acts is a false alarm
    generated     random valid missions, by seed
    proofs        flights within what the check assumed, against what it proved

What does not live here: the rig that flies, with the program that can be killed and restarted
(rig), what can go wrong with the vehicle (links.simulated.faults), what is proved (check).
"""
