"""Two logs compared by what they mean."""
