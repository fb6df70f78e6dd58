"""The version, on the ground floor so that every room may name it."""

VERSION = "0.1.0"
