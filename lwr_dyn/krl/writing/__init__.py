"""Programs written from other data: a list of points."""
