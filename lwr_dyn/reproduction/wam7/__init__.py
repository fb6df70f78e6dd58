"""The WAM paper recomputed: its eight simulations with friction."""
