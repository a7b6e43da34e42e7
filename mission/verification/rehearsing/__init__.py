"""A mission flown many times, each in another sea that it assumes: what it will bring home, and how
often."""
