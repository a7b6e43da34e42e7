from __future__ import annotations


def setup(app):
    return {"parallel_read_safe": True}
