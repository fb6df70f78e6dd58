"""Rollouts: whole closed loops of many runs at once, in one kernel generated for arm and law, reduced on the way.

compiled_loop        The loop "compiled" of `simulate`: one run as a scalar kernel that keeps every sample, with
                     record and audit
kernel               A rollout kernel: the source of its driver over blocks of W runs, its machine code, and its runs
                     over threads
kernel_task          What a kernel is made from, and what it computes: plan and task of a call of `rollouts`, from its
                     arguments
law_forms            The kernel form of a controller: its torque on symbols, its memory, and its gains as values of a
                     run
loop_setup           What goes into rollouts, checked: the loop that runs share, and the parameters that differ from run
                     to run
passivity_law_forms  Kernel forms of the laws of Slotine and Li: adaptive (a load or all links, with friction if
                     adapted), and robust
philox_code          Random numbers by counting, Philox 4x32-10: (run, sample, block) and a seed become numbers; in
                     NumPy and in kernels
result               What rollouts give: metrics of every run, flags, and each run again, whole, by `simulate`
rollouts             `rollouts`: many runs of one closed loop at once, with parameters of their own, reduced to
                     metrics on the way
step                 One sample of a closed loop on symbols, as one straight line: reading, law, delay, saturation,
                     figures, RK4 substeps
substeps             How many RK4 steps a sample smooth friction needs: the error of the step, estimated by runs with
                     twice as many
symbolic_arm         An arm on symbols: its dynamics, as a law or a plant knows it, and the plant's friction, tip and
                     step of RK4
"""
