"""The jobs of a run: planned, estimated, foreseen, and what is missing of them in the end."""
