"""The same task under all readings of a robot: what depends on the reading, and which conclusions survive it."""
