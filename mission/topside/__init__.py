"""The programs on the boat: conversations with a Pi, by radio or under water."""
