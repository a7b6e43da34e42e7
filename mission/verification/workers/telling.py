"""Lines from within a job, on the standard error of the command that has asked for the job."""

from __future__ import annotations

import sys


def tell(line: str) -> None:
    """Print a line. From a Dask cluster the scheduler sends it to the command."""
    if "distributed" in sys.modules:  # else no cluster runs this
        from distributed import print as sent

        sent(line, file=sys.stderr, flush=True)
    else:
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()
