"""Motions composed: chains of joints, and two chains seen from each other."""
