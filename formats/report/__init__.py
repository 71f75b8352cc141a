"""A log as one page for people: what was found, drawn so that it is seen at a glance."""
