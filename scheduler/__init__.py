"""The theory: bodies, motions and their bounds, the heap, the narrow phase, the events. No files, no printing."""
