"""References that people bring (files, steps, chirps), and what a loop made of them.

motion_file         read_motion: a CSV of joint positions or poses over time
pose_motion         joint positions for recorded poses
motion_reference    the task csv
excitations         the tasks step and chirp
step_response       step_responses: rise, overshoot, settling
frequency_response  frequency_responses: H(f), bandwidth
response_text       these in words and as JSON
response_figures    these as figures
twice               Twice: a reference twice; part_of: one pass of a run
"""
