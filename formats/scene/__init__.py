"""The native scene file: reading with line numbers, grammar, meshes."""
