"""Laws of motion along time, paths and orientations in space, and timed pose paths; knows no arm."""
