"""What is wrong before a dive: rows of checks, and listening at the vehicle's side."""
