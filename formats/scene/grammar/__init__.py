"""The grammar of a native scene: what may be written where."""
