"""What is known of one pair, and when it wakes."""
