"""The robot as a KUKA controller describes it: X, Y, Z, A, B, C, Status and Turn."""
