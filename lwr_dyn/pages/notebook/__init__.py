"""Results in a notebook; the core works without.

forms  Results as one or two kilobytes of HTML, which a notebook shows in place of their text
plot   `lwr_dyn.plot`: a picture of runs that any notebook draws, and that `simulate --plot` writes
"""
