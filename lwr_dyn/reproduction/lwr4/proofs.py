"""Proofs of the errata."""

from lwr_dyn.reproduction.ledger import Prove

PROOFS: dict[str, Prove] = {}
