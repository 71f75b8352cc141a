"""Bytes of YAML and JSON to values that know their line and column."""
