"""Numbers of a scene file to SI: units, poses, rotations."""
