"""Convert parts of black boxes to their final form, at the lowest priority.

python -m mission.onboard.blackbox PART...
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from mission.onboard.blackbox.closed import close_each

_GIVES_WAY = 19


def main(*parts: str) -> None:
    os.nice(_GIVES_WAY)
    close_each(map(Path, parts))


if __name__ == "__main__":
    main(*sys.argv[1:])
