"""Published sets of one robot, ranked on a log of the real one (`lwr-dyn rank`).

filtered_log     A log as all sets are scored on it: positions and torques through one filter, even rows
identified_set   Our own set of a ranking: bodies identified on the rows that train, with the filter of the ranking
published_logs   Logs of real robots by address and digest, two of them here; the others are fetched by the user
rank             The ranking: sets, what is fitted beside each, held-out torques, the floor, intervals
ranking_page     The page of a ranking: torques of each set against measurement, joint by joint
ranking_result   A ranking of sets: each with what it leaves, and the document of all
set_fits         Torques of one set and what is fitted beside it: friction, rotors, couplings, gains, a free load
"""
