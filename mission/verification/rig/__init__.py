"""Runtime, simulated vehicle, links and operators in lock step, and the trace that laws judge."""
