"""``auvmission``, and ``python -m mission``. Runs the lifeboat if ``serve`` cannot be loaded."""

from __future__ import annotations

import os
import sys
import traceback


def main() -> None:
    try:
        from mission.cli import main as commands

        commands(prog_name="auvmission")
    except Exception as error:
        if sys.argv[1:2] != ["serve"]:
            raise
        _lower_lifeboat(error)


def _lower_lifeboat(error: Exception) -> None:
    """Bring the vehicle up without the program, whatever failed: an import, a damaged file."""
    from mission.onboard.lifeboat import launch, plan_from

    traceback.print_exception(error)
    plan = plan_from(sys.argv[2:], os.environ)
    if plan is None:
        raise SystemExit(1)
    sys.stderr.write("serve cannot run: this only brings the vehicle up, and hears nobody\n")
    launch(plan)


if __name__ == "__main__":
    main()
