"""Equilibria of soft tissue as minima of one potential energy."""
