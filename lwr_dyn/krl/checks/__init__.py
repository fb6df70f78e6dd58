"""What can be diagnosed without running: names, types, declarations, initial values, jumps."""
