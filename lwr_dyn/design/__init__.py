"""Design of the sampled loop: what sampling, delay and elastic joints leave of its stability, and of its motion.

sampled_loop       RestingPlant and RestingLoop: plant and loop near rest as matrices, the step from sample to sample
sampled_stability  share of unstable poses, worst pose, least rate; the joint box elastic_loop       arms with elastic
joints as matrices, at rest and frozen along a motion; where laws are stable on them loop_margins       |S_ii|, gain and
delay margins of one loop at one pose; state spaces for python-control loop_judgement     LoopCase, how a loop is
sampled; what `gains` and `simulate` say of it margins            `lwr_dyn.margins`: the report over poses, and in words
gain_search        the largest omega_n that keeps a stated margin path_pieces        the path of a reference in pieces
time_optimal       least_time: the least time along a path under limits of torque, speed and acceleration; its task
time_optimal_speeds  limits on the path's speed and acceleration, s(t); the only door to toppra
"""
