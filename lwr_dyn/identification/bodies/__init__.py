"""Whether bodies can have estimated parameters.

possible_bodies  two tests, each of which proves that none do
"""
