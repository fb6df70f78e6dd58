"""Laws, agreement of the two roads, feasibility of the links: a verdict each."""
