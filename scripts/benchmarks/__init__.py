"""The parts of `scripts/benchmark.py`, and what they share."""
