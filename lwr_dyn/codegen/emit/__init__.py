"""Code for other machines: an arm's functions as one file of C or JavaScript that needs nothing else.

functions       what can be emitted: arguments with units, result, the function on symbols; templates with branches
straight_code   a function on symbols -> operations in order, each once, and where results are stored
emission        the functions of an arm for one file; the registry of languages
provenance      the comment at the top: robot, reading, errata, hash, versions, units
cases           test vectors
c_source        operations -> C99; c_file: the file and its header; c_self_test: its test program
javascript      operations -> JavaScript; javascript_file: script or ES module; javascript_shared: what functions share
identifiers     names of C and JavaScript
laws            control laws as one step; friction: torque of the joints' friction
compact         the torque regressor's distinct numbers
closed_form     inverse kinematics from the templates branches_*.c; closed_form_cases: its test vectors
restricted_c    a small part of C -> C with an arm's constants, and JavaScript
command         `lwr-dyn kernels`
"""
