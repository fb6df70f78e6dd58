"""B, C and g by two roads: Pinocchio on the URDF, and the hand-written Newton-Euler recursion."""
