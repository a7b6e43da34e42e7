"""One file per vehicle: its frame table, Telemetry in, Setpoint out."""
