"""Programs written from other data: a list of points, a run, a table of poses or axes.

point_program    a list of points; lines of a program that is written
sampled_path     a run, a motion or a table as samples
path_fit         motions that follow samples; how far a run is off
motion_program   motions -> a program with speeds and approximations
path_program     blocks; writes, runs and keeps what holds
"""
