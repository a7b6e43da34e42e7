"""The black box: every record in an MCAP file, readable after a power cut at any byte.

form      the bytes of a growing file      reading     whole records, and the gaps between them
box       the writer                       scan        whole records in damaged bytes
closed    converts closed parts            first_form  converts records of the first form
parts     names of recordings and parts    tail        reads a file that is being written

What does not live here: the payloads (runtime.records), values derived from them (stream), the
comparison with a replay (analysis.replay).
"""

from mission.onboard.blackbox.box import BlackBox
from mission.onboard.blackbox.closed import (
    close_each,
    close_part,
    close_recording,
    notes_of,
    told_start,
)
from mission.onboard.blackbox.form import FLUSH_S, KINDS, LIMIT, MAGIC, BlackBoxError
from mission.onboard.blackbox.parts import file_name, first_part, free, part_path
from mission.onboard.blackbox.reading import (
    Gap,
    missing,
    read_parts,
    read_records,
    recording,
)
from mission.onboard.blackbox.tail import GrowingBox, Tail

__all__ = [
    "FLUSH_S",
    "KINDS",
    "LIMIT",
    "MAGIC",
    "BlackBox",
    "BlackBoxError",
    "Gap",
    "GrowingBox",
    "Tail",
    "close_each",
    "close_part",
    "close_recording",
    "file_name",
    "first_part",
    "free",
    "missing",
    "notes_of",
    "part_path",
    "read_parts",
    "read_records",
    "recording",
    "told_start",
]
