"""Slips of a table, traced by a log.

printed_cells  the cells as the source prints them, the parameters they stand for, which of them motions show
repairs        the slips that hands make, undone
hypotheses     a table with repairs, judged by a log in which friction is free
trace          the fewest repairs with which a table meets a log; one factor on all bodies, which is no slip
slip_tables    every cell against the log; text, record and the card of a page
"""
