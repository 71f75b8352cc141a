"""Files in (scenes, meshes) and out (the MCAP log and its summary)."""
