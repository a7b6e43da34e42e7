"""Extensible tables of rows, for the packages of ``mission``. Links and frames import the same
classes from ``protocol.tables``."""

from protocol.tables import Table, derived

__all__ = ["Table", "derived"]
