"""The program on the Pi: asyncio around the drive, and what keeps it alive and closed."""
