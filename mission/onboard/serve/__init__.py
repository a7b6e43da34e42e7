"""The program on the Pi: asyncio around the runtime, and what keeps it alive and closed."""
