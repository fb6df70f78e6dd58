"""KUKA Robot Language: programs as data, read, written, checked and run on a robot's model."""
