"""How long a pair may sleep: one bound a file."""
