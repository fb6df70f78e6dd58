"""Two states of a program or a backup: points moved by how much, other values that changed, lines that differ."""
