"""The report of an identification as one HTML page.

charts         Figures of the report: torques against their prediction, friction over speed, and the arm in 3D with the
               ellipsoids of its links before and after
motion_report  A fit to any motion as a page: its document with the motion in 3D, torques, friction and the recordings
"""
