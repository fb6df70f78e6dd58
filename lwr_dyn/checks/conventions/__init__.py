"""The conventions of a table that states none: every reading, ranked, and what decides it.

candidates        Candidate readings of a hypothesis, in their order; a link read otherwise than the rest counts as an
                  exception
cell_corrections  Single wrong cells, where no reading of a table gives the published numbers
evidence          What a source publishes beside its table: numbers derived from it, a second set of tensors, poses,
                  repeated links
hypotheses        Hypotheses about a whole table: one choice of conventions, with every body that each link can then
                  be
printed_table     A table as its source prints it, the conventions that it leaves open, and the bodies that follow
                  from each choice
ranking           Ranks the readings of a table that states no conventions: by frames, published numbers, bodies,
                  repeated links
ranking_text      Ranked readings as sentences and tables: what each criterion gives and decides, and what nothing
                  decides
search            Which bodies of the links give the published numbers: a search from the flange inward, one link at a
                  time
"""
