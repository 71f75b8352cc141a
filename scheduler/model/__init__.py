"""What a run is about and what it says: bodies, rules, events."""
