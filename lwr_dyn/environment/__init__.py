"""What acts on an arm from outside: walls that it touches, pushes against its links."""
