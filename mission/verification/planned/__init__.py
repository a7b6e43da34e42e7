"""What a mission means to do, before it is rehearsed: its track in still water, drawn."""
