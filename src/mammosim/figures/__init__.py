"""Tidy table in, matplotlib figure out."""
