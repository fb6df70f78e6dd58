"""Segments and blends in time.

cycle_times      The cycle time by three laws, because no published figure of KUKA's decides between them
motion_segments  Motion segments from rest to rest, planned as a controller does: PTP along the axes, LIN and CIRC
                 along a path
pose_paths       Paths of the tool centre point with their orientation, the axes along them, and the fastest speeds on
                 them
splines          SPLINE and PTP_SPLINE blocks, planned whole: their path, and the fastest speeds on it under all
                 bounds, rest to rest
timeline         Motion segments and pauses in time; in a blend a segment begins while the one before it still slows
                 down
"""
