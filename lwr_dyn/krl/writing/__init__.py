"""Programs written from other data: a list of points, a run, a table of poses or axes."""
