"""Generated code for one arm: batch dynamics and inverse kinematics on symbols, simplified, written, compiled.

batch                `BatchDynamics`, `batch_dynamics`: functions over rows of states; the engine "kernels"
kernel_spec          the functions of a batch, what can be an input of them; `KernelSpec`, the arm and its options
lean_recursion       the recursions that are traced, in the joints' own axes, on base parameters
symbolic_functions   all functions of a batch on symbols
straight_line        expressions -> `StraightLineCode`, each operation once
elementary           sine, cosine, exponential, ... without a branch
result_form          how results lie in memory, and which entries are stored at all
kernel_source        straight-line code -> Python source over blocks of states
lowering, transposes  numba intrinsics: the body as vector instructions, rows to lanes and back
machine_code         source -> object code -> a function in memory
kernel               `Kernel`: of this process, from the cache on disk, or compiled now
pose_kernel          the search for one solution of a pose; pose_source its step, pose_driver the loop around it
"""
