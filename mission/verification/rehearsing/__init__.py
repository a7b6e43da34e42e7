"""A mission flown many times, each in another sea within its assumptions: what it achieves, and how
often."""
