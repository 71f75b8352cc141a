"""The theory: bodies, motions, bounds, the queue, exact distances, events. It reads no files and prints nothing."""
