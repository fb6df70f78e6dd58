"""Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the way.

rollouts           `rollouts`, the front door; result is `Rollouts`, each run again by `simulate` (replay)
loop_setup         the loop that all runs share, checked; run_parameters what differs from run to run
laws               controllers in the form that kernels take
symbolic_model     an arm's dynamics on symbols; symbolic_plant with friction, tip and a step of RK4 (small_turn)
sensing            encoder and delay; philox, philox_code, counted_encoder their noise; smooth_friction
step               one sample as a straight line on the slots of a run; step_figures its sums and extremes
step_source        the driver over blocks of runs; kernel compiles, keeps and runs it
task_of_runs       parameters -> what a kernel takes; bodies_of_runs inertial parameters and arms of runs
figures            metrics from sums and extremes, or from a `Run`; flagged_runs those that `simulate` computes
compiled_loop      `run_compiled`: one run with every sample, the loop "compiled" of `simulate`
whole_source       its kernel as Python text
whole_kernel       its kernel, compiled
loop_limits        what it lacks, refused by name
"""
