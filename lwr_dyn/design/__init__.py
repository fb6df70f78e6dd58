"""Design of the sampled loop, what sampling, delay and elastic joints leave of its stability, and of its motion.

- `resting_plant`: RestingPlant, a plant near rest as matrices, its exact step with the torque held;
- `elastic_loop`: arms with elastic joints as matrices, at rest and frozen along a motion; continuous poles;
- `elastic_table`: where laws are stable on elastic joints: poles at a moment, unstable shares of the joint box;
- `loop_case`: LoopCase, how a loop is sampled and whether its joints are elastic;
- `law_differences`: the linear form of a controller that gives none, by differences;
- `sampled_loop`: RestingLoop, the sampled loop at rest as a linear map, its spectral radius;
- `loop_response`: the loop over frequency, |S_ii| of each joint with all others closed;
- `loop_margins`: gain and delay margins of one loop at one pose;
- `joint_box`, `sampled_stability`: share of unstable poses, worst pose, least rate;
- `margins`: `lwr_dyn.margins`, the report over poses; `margins_text`, `state_spaces`: in words, for python-control;
- `gain_search`: the largest omega_n that keeps a stated margin;
- `sampled_gains`, `command`: the sampled loops of all controllers with given gains; `lwr-dyn gains`;
- `sampled_text`: these results in words, for the commands `gains` and `simulate`.
- `time_optimal`: least_time, the least time along a path under limits of torque, speed and acceleration;
- `time_optimal_pieces`, `time_optimal_limits`, `time_optimal_profiles`: the path of a reference, limits on it, s(t);
- `toppra_solver`: the only door to toppra;
- `time_optimal_task`: the task `least-time`.
"""
