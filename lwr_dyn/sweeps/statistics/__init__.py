"""What the runs of a study say: quantiles, shares and indices with their intervals, what breaks a limit."""
