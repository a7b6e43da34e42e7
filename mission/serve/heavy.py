"""What a mission will need and takes long to import, in a thread, before anybody waits for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mission.drive.drive import Drive

if TYPE_CHECKING:
    from mission.navigation import Navigation


def prepare(drive: Drive) -> Navigation:
    import mission.check
    import mission.language.assembly
    import mission.language.lines  # noqa: F401

    return drive.make_navigation()
