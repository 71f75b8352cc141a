"""Readers of trajectory files, a layout each."""
