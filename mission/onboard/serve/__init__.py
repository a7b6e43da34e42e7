"""The program on the Pi: asyncio around the runtime, with its ports, files and watchdog."""
