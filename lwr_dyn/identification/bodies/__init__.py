"""Bodies that have the estimated parameters, or a proof that none do.

body_prior       What a table says of the parameters before any log: how far bodies and rotors are from it, as a log-
                 det distance
consistent       The physically consistent fit: bodies that explain the torques and are as near to the table as the
                 log allows
link_spreads     How links may differ from a table, kind by kind: shape, centre, tensor, mass
possible_bodies  Whether bodies exist that have the identified base parameters: two tests, each of which proves that
                 none do
table_posterior  What a log and a table say together of links and rotors, with scales of their difference that the log
                 finds
"""
