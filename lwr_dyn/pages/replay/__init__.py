"""Runs in 3D and as figures.

replay_page    replay_html, write_replay: one HTML file that replays runs in 3D
live           serve: the same page, connected to a meshcat server on this machine
replayed_runs  ReplayedRun: a run with its arm, label and place in the palette
scene          the arm as meshcat commands
figures        descriptions of figures
look           colours, type and fonts of all pages and pictures
page_parts     templates, scripts and packed numbers for one-file pages
"""
