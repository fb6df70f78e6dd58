"""The page that replays a run of a program, with the program's lines beside the motion."""
