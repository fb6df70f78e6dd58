"""A program: its files, the names they declare, and which of them a routine sees."""
