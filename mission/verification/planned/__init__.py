"""The track that a mission plans, as it would be flown in still water, and its picture."""
