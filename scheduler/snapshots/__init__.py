"""What viewers show at an instant; proves nothing."""
