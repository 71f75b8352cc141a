"""Readers of mesh files, a format each."""
