"""Code for other machines: an arm's functions as one file of C or JavaScript that needs nothing else.

c_file             A file of C99 and its header: provenance, guards, the functions, a self-test behind #ifdef
closed_form        Closed-form inverse kinematics as C and JavaScript: S-R-S arms, six joints with spherical wrist or
                   parallel axes
emission           The functions of an arm for one file, and what all of them share: names, the comment at the top,
                   test vectors
fmu                An arm, or a control law at samples, as an FMU: C sources with the functions of FMI 2.0 or 3.0 around
                   them
fmu_description    The modelDescription.xml of an FMU: arrays in FMI 3.0, one scalar variable a number in FMI 2.0
functions          What can be emitted for an arm: each function with arguments, units and result, on symbols and as
                   operations
further_functions  Functions beside those of a batch: the regressor by its distinct numbers, friction, and control
                   laws as one step
javascript_file    An arm's functions as one JavaScript file: a plain script that defines one name, or an ES module
restricted_c       The texts of `kinematics.closed_forms` as C with an arm's constants and as JavaScript: one text, two
                   languages
tangents           Derivatives along a direction, made from emitted functions by forward mode
"""
