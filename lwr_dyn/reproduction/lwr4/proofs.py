"""Proofs of the errata."""

from lwr_dyn.reproduction.proof import Prove

PROOFS: dict[str, Prove] = {}
