"""Design of the sampled loop: what sampling, delay and elastic joints leave of its stability, and of its motion.

defaults             What a loop gets where nothing is asked for: a task, a law; each with a line that says what was
                     chosen and why
elastic_loop         Arms with elastic joints as matrices: near rest, and frozen at a moving state; continuous poles
                     of their loops
gain_search          The largest natural frequency omega_n with which a law keeps a stated margin, over poses and over
                     several plants
loop_judgement       What a loop is judged with (`LoopCase`), and what sampling does to it in words
loop_margins         The margins of one sampled loop at one pose: poles, |S_ii|, how far gains and delay may move
margins              `lwr_dyn.margins`: what sampling, delay and elastic joints leave of a loop's stability, and where
                     it is worst
path_pieces          The path of a reference without its timing: pieces q(s) that can be passed without a stop, and
                     the way back
sampled_loop         The sampled loop at rest as a linear map from one sample to the next, and the spectral radius of
                     that map
sampled_stability    Where in the joint box, or along a motion, a sampled loop is unstable at rest: share, worst pose,
                     least rate
time_optimal         The least time in which an arm can follow a path: `least_time`, by toppra, with a share of the
                     torque kept back
time_optimal_speeds  Limits of torque, speed and acceleration along a path q(s), in the squared speed x = ds^2 and u =
                     dds
"""
