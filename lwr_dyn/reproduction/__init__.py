"""The papers recomputed, one module each."""
