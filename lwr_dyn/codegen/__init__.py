"""Code generated for one arm: functions over rows of states, whole closed loops, and files of C and JavaScript.

branches  Inverse kinematics as machine code: the texts of the closed forms, by LLVM
emit      Code for other machines: an arm's functions as one file of C or JavaScript that needs nothing else
kernels   Generated code for one arm: batch dynamics and inverse kinematics on symbols, simplified, written, compiled
rollouts  Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the
          way
"""
