"""Replay of the recorded inputs through the same runtime, up to the first difference."""
