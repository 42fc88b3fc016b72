"""The same problems solved by other programs."""
