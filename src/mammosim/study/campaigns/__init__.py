"""Campaigns: one table of what a chain answers over any settings, of any number of points."""
