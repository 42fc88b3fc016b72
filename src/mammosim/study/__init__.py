"""What is asked of the chain: a subpackage per question."""
