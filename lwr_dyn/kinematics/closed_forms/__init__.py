"""Closed forms of inverse kinematics, written once in a small part of C, from which every language is made.

arm_numbers  The numbers of an arm in the texts of its closed form, by their names there
texts        The closed forms as texts in a small part of C, from which C, JavaScript, Python and machine code are made
"""
