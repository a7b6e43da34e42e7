"""The black box: every record in an MCAP file, readable after a power cut at any byte.

form      the bytes of a file that grows     reading     what is whole, and what is missing
box       what writes it                     scan        whole records out of damaged bytes
closed    a part that is closed, in chunks   first_form  what the first form's payloads were
parts     names, and parts of a recording    tail        a file that is being written

What does not live here: what the payloads mean (runtime.records), what is derived from them
(stream), the comparison (analysis.replay).
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
