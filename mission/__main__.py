"""``python -m mission`` is ``auvmission``."""

from mission.cli import main

if __name__ == "__main__":
    main(prog_name="auvmission")
