"""Code generated for one arm: functions over rows of states, whole closed loops, and files of C and JavaScript.

kernels   batch dynamics and the search for a pose, compiled in the process and kept on disk
rollouts  closed loops of many runs at once
emit      an arm's functions and laws as C or JavaScript
"""
