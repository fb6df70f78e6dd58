"""The page of a run.

program_page   replays a run with its program beside the arm
"""
