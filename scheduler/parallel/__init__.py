"""The same bytes from many processes."""
