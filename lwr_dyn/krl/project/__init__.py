"""A program: its files, the names they declare, and which of them a routine sees.

program  A program: one module of a project, with all the names that it sees; and how files and folders become one
project  A project: modules that see one another, as a KUKA controller sees them, and the names that they declare
"""
