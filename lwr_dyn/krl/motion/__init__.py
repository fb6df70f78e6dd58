"""Segments and blends in time.

pose_paths        paths in space, the axes along them, the fastest speeds on them
motion_segments   PTP, LIN and CIRC from rest to rest
splines           SPLINE and PTP_SPLINE blocks
timeline          segments, pauses and blends in time
cycle_times       the cycle time by three laws of look-ahead
"""
