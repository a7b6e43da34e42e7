"""A second sea, by another hand: the proof that the vehicle comes home in water nobody prepared.

Body, boards, receiver, modem and operators were written from the documents of the vehicles and from
what is known of the vehicle as it is, and import no line of the program. The program runs as it does
on the Pi, as a process (`python -m mission serve`), and the two talk in bytes over pseudo-terminals
and TCP. Laws judge by truth and by bytes, never by what the program says of itself.

    python -m tests.sea                 # every scene
    python -m tests.sea SCENE --seed 7  # one of them, with another draw of noise and phases
    python -m tests.sea --draw 50       # 50 scenes drawn at random from the same tables

Time is the sea's own (`clock`): it advances when the program has nothing left to do.
"""

import sys
from pathlib import Path

# As pytest has it (pyproject, `pythonpath`), also where a scene is flown by hand.
sys.path.append(str(Path(__file__).parents[1] / "worlds"))
