"""Control laws beyond the paper, one a file: they join the registry of controllers."""
