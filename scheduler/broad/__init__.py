"""Swept boxes over windows of time: which pairs need to be known at all."""
