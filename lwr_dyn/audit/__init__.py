"""Slips in tables, how a table is read, and what depends on the reading."""
