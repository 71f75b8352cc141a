"""Points, directions, transforms and how they round; knows no body."""
