"""A short mission of a pool, and what is uploaded of it."""

from __future__ import annotations

from mission.authoring.language import digest, parse, script

TEXT = """mission pool vehicle auv
home 30.2874595 120.1535765
safety radius 400 time 20min depth 10 voltage 10
assume current 0.1
dive: depth 3 heading 0 gear 4 until depth >= 2.5 timeout 90
repeat 2 rows:
out: heading 90 gear 6 for 20s
back: heading 270 gear 6 for 20s
end
up: surface timeout 3min
"""
MISSION = parse(TEXT)
LINES, DIGEST = script(MISSION), digest(MISSION)
