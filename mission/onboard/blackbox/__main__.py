"""The parts of black boxes in a folder into their last form, giving way to everything else.

python -m mission.onboard.blackbox FOLDER [PART]     all but PART, which is being written
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from mission.onboard.blackbox.closed import close_folder

_GIVES_WAY = 19


def main(folder: str, but: str = "") -> None:
    os.nice(_GIVES_WAY)
    close_folder(Path(folder), Path(but) if but else None)


if __name__ == "__main__":
    main(*sys.argv[1:])
