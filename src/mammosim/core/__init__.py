"""Types and constants that every science shares; needs numpy only."""
