"""Missions, the state machine that flies them, and everything around it."""

__version__ = "0.1.0"
