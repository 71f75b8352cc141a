"""The subject of a run and its events: bodies, rules, verdicts."""
