"""Slips of a table, traced by a log.

hypotheses     A table with repairs, judged by a log: chi^2, and the evidence that weighs a free value against a
               stated slip
printed_cells  The inertial cells of a table as its source prints them, and the parameters of the torques that they
               stand for
repairs        The slips that hands make in tables of inertias, undone: every table that one repair of a given one
               yields
slip_tables    A table against a log: what each cell would be if it alone were wrong; its slips as document
               and card of a page
trace          Slips of a table traced by a log: the fewest repairs with which the table meets it, and what have the
               same effect
"""
