"""Code for other machines: an arm's functions as one file of C or JavaScript that needs nothing else.

functions       what can be emitted: arguments with units, result, the function on symbols
straight_code   a function on symbols -> operations in order, each once, and where results are stored
c_source        operations -> C99
"""
