"""Moves bytes; knows nothing of what they mean."""
