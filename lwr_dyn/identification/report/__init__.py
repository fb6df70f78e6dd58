"""The report of an identification as one HTML page.

arm_stage      The arm in 3D that replays the recordings, with the ellipsoids of its links before and after, for
               report.js
charts         Charts of the report: torques against their prediction with what is left, and friction over speed with
               the fit
motion_report  A fit to any motion as a page: its document with the motion in 3D, torques, friction and the recordings
"""
