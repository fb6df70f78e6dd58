"""The LWR 4+ paper recomputed: worst-case inertias, gains, both controllers on IST."""
