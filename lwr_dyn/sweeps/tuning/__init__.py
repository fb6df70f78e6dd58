"""Gains found on rollouts for a stated aim."""
