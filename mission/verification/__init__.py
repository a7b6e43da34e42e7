"""How the engine is tested: simulated flights, fault campaigns, every state with every event."""
