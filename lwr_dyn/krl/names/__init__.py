"""Types of KRL, and the names that need no declaration.

known_names  Types of KRL, and the names that need no declaration: KUKA's own, those of option packages, those of a
             user's file
"""
