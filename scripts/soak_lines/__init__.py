"""The lines of `scripts/soak.py`, one file a subject; `LINES` there names them."""
