"""Design of the sampled loop, and of its motion: where sampling makes a controller unstable, the least time of a path.

- `resting_plant`: RestingPlant, a plant near rest as matrices, its exact step with the torque held;
- `sampled_loop`: RestingLoop, the sampled loop at rest as a linear map, its spectral radius;
- `sampled_stability`: stability_in_box, stability_along: share of unstable poses, worst pose, least rate;
- `sampled_gains`: the sampled loops of all controllers with given gains;
- `command`: `lwr-dyn gains`;
- `sampled_text`: these results in words, for the commands `gains` and `simulate`.
- `time_optimal`: least_time, the least time along a path under limits of torque, speed and acceleration;
- `time_optimal_pieces`, `time_optimal_limits`, `time_optimal_profiles`: the path of a reference, limits on it, s(t);
- `toppra_solver`: the only door to toppra;
- `time_optimal_task`: the task `least-time`.
"""
