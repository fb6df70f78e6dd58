"""The page of a run.

program_page  One HTML file that replays a run with its program beside the arm: the line that moves it now is marked
"""
