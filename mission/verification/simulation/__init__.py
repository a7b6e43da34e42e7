"""Flights on the simulated vehicle: in lock step, or as three processes for the demonstration."""
