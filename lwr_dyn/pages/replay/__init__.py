"""Runs in 3D, as one file or live.

replay_page    `replay_html`, `write_replay`; the parts of all one-file pages
live           `serve`: the same page, connected to a meshcat server on this machine
replayed_runs  `ReplayedRun`: a run with its arm, label and place in the palette
look           colours, type and fonts of all pages and pictures
"""
