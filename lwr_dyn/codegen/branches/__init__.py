"""Inverse kinematics as machine code: the texts of the closed forms, by LLVM.

compiled_text  The text of a closed form as a function in memory: of this process, from the cache, or compiled now
"""
