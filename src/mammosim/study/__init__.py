"""What is asked of the chain: a room per question."""
