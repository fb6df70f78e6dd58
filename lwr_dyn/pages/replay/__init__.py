"""Runs in 3D, as one file or live.

drawn_shapes   The cylinders that a page draws of an arm: those of its file, but no two of them share a visible
               surface
live           Live replay: meshcat's own server, bound to the loopback address 127.0.0.1 only
look           The look of pages and pictures: the tokens of `look.css` (colours light and dark, type, spacing) and
               the fonts
replay_page    Runs -> one HTML file that replays them in 3D: meshcat's viewer, the runs and our player in one page
replayed_runs  `ReplayedRun`: a run with its arm, label and place in the palette; every picture starts from it
"""
