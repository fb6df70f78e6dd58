"""Runs of a study in chunks: on threads, processes or a cluster, killed and resumed, in a folder of results."""
