"""Bodies that have the estimated parameters, or a proof that none do.

pseudo_inertia   the ten parameters of a body as a 4 x 4 matrix, positive exactly if it can be a body
body_prior       how far bodies, rotors and friction are from a table: a log-det distance
constraints      what is known for certain: total mass, values, sums; contradictions are named
newton           the bodies nearest to values with a precision and to a prior, by a damped Newton method
weighted_fit     the optimum under given weights of table and rotors, and which weights a log favours
consistent       the fit whose every link is a body
possible_bodies  two tests on base parameters, each of which proves that no bodies have them
"""
