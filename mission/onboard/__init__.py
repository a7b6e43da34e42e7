"""The program on the Pi inside the vehicle: the runtime, `serve`, and the files that they keep."""
