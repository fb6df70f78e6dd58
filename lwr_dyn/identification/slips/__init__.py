"""Slips of a table, traced by a log.

printed_cells      the cells as the source prints them, and the parameters they stand for
discrepancy        how far an arm may be from a table without slips
log_evidence       what a log says of them, friction left free
shown_cells        cells that a motion shows alone, with others, or not at all
repairs, exchanges the slips that hands make, undone
hypotheses         a table with repairs, judged
common_factor      one factor on all bodies, which is no slip
trace              the fewest repairs with which a table meets a log
table_against_log  every cell against the log
slip_tables        text and record
"""
