"""Generated code for one arm: batch dynamics and inverse kinematics on symbols, simplified, written, compiled.

batch                `BatchDynamics`, `batch_dynamics`: functions over rows of states
engine               the engine "kernels" of `dynamics_of`
kernel_spec          the functions of a batch; `KernelSpec`, the arm and the options of its kernels
parameters           quantities that can be inputs: inertial parameters, payload, gravity, friction
batch_arguments      arguments -> rows that a kernel can step through
lean_recursion       the recursions that are traced, in axis_frames, on base_parameters
symbolic_dynamics    torque, B and energy on symbols; symbolic_functions all functions of a batch; ldl solves a system
straight_line        expressions -> `StraightLineCode`, each operation once; sincos is sine and cosine without a branch
kernel_source        straight-line code -> Python source over blocks of states
lowering, transposes  numba intrinsics: the body as vector instructions, rows to lanes and back
machine_code         source -> object code -> a function in memory
kernel, cache        `Kernel`: loaded, from the cache on disk, or compiled now
pose_*               the search for one solution of a pose: step, lanes, driver, source, `kernel_search`
command              `lwr-dyn kernels`
"""
