"""Arms from names and files, and arms as files.

loading  `load`: a robot by name or file, with its mount and tool
papers   data files, one a paper
urdf     URDF out and in
export   DH tables, data files, MJCF
"""
