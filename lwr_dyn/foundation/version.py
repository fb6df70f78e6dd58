"""The version, in a module without imports so that every other module can use it."""

VERSION = "0.3.0"
