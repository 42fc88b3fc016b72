"""How a computation ended, in tables."""

VERIFIED = "verified"  # the residual of the equilibrium was checked
