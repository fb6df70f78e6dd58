"""Generated batch dynamics: the hand-written recursion traced, simplified, written out and compiled for one arm.

trace (CasADi) -> program (each operation once) -> source (Python, blocked) -> build (numba) -> cache -> batch, engine
"""
