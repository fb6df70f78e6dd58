"""datasheet."""
