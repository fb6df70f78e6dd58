"""Lint of printed tables: slips that show without a model, in any file of numbers."""
