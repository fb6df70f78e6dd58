"""Code for other machines: an arm's functions as one file of C or JavaScript that needs nothing else.

functions          what can be emitted: arguments with units, result, the function on symbols, its operations in order
further_functions  the regressor by its distinct numbers; friction of the joints; control laws as one step
emission           the functions of an arm for one file: names, the comment at the top, test vectors; the languages
c_file             C99: file, header and self-test
javascript_file    a plain script or an ES module
closed_form        inverse kinematics from the templates branches_*.c, with its test vectors
restricted_c       a small part of C -> C with an arm's constants, and JavaScript
"""
