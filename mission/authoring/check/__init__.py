"""The check: prove bounds of a mission before it is flown, and refuse unsafe missions.

from mission.authoring.check import check_mission
report = check_mission(chart, vehicle)      # report.ok, .refusals, .proved, .assumed
"""

from mission.authoring.check.rules import (
    Proved,
    Report,
    before_the_proof,
    check_mission,
    check_ways,
    no_home,
)

__all__ = ["Proved", "Report", "before_the_proof", "check_mission", "check_ways", "no_home"]
