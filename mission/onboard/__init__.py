"""What runs on the Pi inside the vehicle: the runtime, `serve`, and what they keep."""
