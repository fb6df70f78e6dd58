"""The LWR-IV exercise recomputed."""
