"""What the report says, and how its pages are made."""
