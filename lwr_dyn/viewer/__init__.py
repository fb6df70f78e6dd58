"""What a run looks like: the one-file replay page, the live meshcat, the plots."""
