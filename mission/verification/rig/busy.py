"""The error of a lock step that does not come on; by itself, since a compiled module has none."""


class Busy(RuntimeError):
    """Somebody is due again and again at one instant."""
