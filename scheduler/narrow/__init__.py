"""Distances at one instant, exact to a stated error; the one door to FCL."""
