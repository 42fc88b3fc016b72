"""How accurate an answer is, and what that costs."""
