"""Motions in time: PTP, LIN and CIRC as segments, and their blends on a timeline."""
