"""Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the way.

rollouts            `rollouts`, the front door; a single run again by `simulate`
loop_setup          the loop that all runs share, checked; run_parameters what differs from run to run
law_forms           controllers in the form that kernels take; passivity_law_forms those of Slotine and Li
symbolic_model      an arm's dynamics on symbols; symbolic_plant with friction, tip and a step of RK4
philox              the encoders' noise, by counting; philox_code as vector instructions
step                one sample as a straight line on the slots of a run: encoder, law, delay, figures, motion
kernel              the driver over blocks of runs, compiled, kept and run
result              `Rollouts`: metrics from sums and extremes, or from a `Run`; runs that `simulate` computes
compiled_loop       `run_compiled`: one run with every sample, the loop "compiled" of `simulate`
"""
