"""From the values of a scene file to the scheduler's bodies and rules."""
