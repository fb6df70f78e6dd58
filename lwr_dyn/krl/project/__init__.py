"""A program: its files, the names they declare, and which of them a routine sees.

project   modules that see one another, and the names that they declare
program   one module with all that it sees; reads files and folders
scope     the names that a routine sees
"""
