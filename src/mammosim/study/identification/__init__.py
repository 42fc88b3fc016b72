"""Moduli from measured positions, what they are worth, and what follows from them."""
