"""The file of a study: what is varied, how its runs are drawn, and the arguments of rollouts that it gives."""
