"""Types of KRL, and the names that need no declaration.

known_names                `Type`, the structures of the language itself, `KnownNames` and the reader of their files
kernel.toml, options.toml  KUKA's own names and those of option packages, as data
"""
