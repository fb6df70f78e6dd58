"""Bodies that have the estimated parameters, or a proof that none do.

possible_bodies  a body's ten parameters as a 4 x 4 matrix; two proofs that no bodies have given base parameters
body_prior       how far bodies, rotors and friction are from a table: a log-det distance; what is known for certain
consistent       the fit whose every link is a body, and the weight of the table that a log favours
"""
