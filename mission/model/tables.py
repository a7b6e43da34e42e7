"""Tables of rows that are made to be added to, as the rooms of ``mission`` use them; the links and
the frames have theirs from the same place."""

from protocol.tables import Table, derived

__all__ = ["Table", "derived"]
