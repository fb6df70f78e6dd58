"""Types of KRL, and the names that need no declaration.

types                      `Type`, and the structures of the language itself
kernel.toml, options.toml  KUKA's own names and those of option packages, as data
known, names_file          the records of such names, and the reader of these files and of a user's
predefined                 the built-in ones as mappings
"""
