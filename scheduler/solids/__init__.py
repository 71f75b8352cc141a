"""What is inside a mesh: its skins, the space that they enclose, which parts cross."""
