"""Compressions that are hard to solve, with what is known of them."""
