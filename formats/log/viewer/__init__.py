"""Pictures of a run for viewers: bodies, their motion, clearances, contacts, and the layout that opens them."""
