"""What viewers show of a run: bodies, their motion, clearances, contacts, and the layout that opens them."""
