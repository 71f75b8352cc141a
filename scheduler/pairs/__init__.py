"""The state of one pair, and its next wakeup."""
