"""Generated code for one arm: batch dynamics and inverse kinematics on symbols, simplified, written, compiled.

batch               Batch dynamics: an arm's functions over rows of states, by compiled kernels
block_loop          The loop of a batch kernel: blocks of W states are copied to a buffer, the body works on its lanes,
                    results go out
box_search          The search over boxes of `control.inertia.certificate` as machine code, the same for all arms
elementary          Sine, cosine, exponential, tanh, logarithm, choices and whole numbers as straight-line code,
                    without a branch
engine              The engine "kernels": generated code for single states and for batches, behind the same gate as
                    the other engines
held_step           One step of RK4 under a held torque as a single call at C level: the method of
                    `simulation.integrators.held_rk4`
kernel              A compiled function: of this process, from the cache on disk, or built now
kernel_source       Generates the body of a kernel as Python: a block of W states is copied to a buffer, the code works
                    on its lanes
kernel_spec         The functions of a batch, and the specification of their kernels: arm, inputs, number type,
                    options; its digest
lean_recursion      The recursions that kernels are generated from: inverse dynamics, and B by composite bodies, in
                    the axes' own frames
lowering            Lowers the body of a kernel, a straight-line loop over lanes, to LLVM vector instructions
llvm_text           Texts in the small part of C (closed forms, loops of kernels) as LLVM's intermediate language
loop_code           The loop of a kernel, a text in the small part of C, and what it calls: one module of LLVM, then
                    machine code
loop_helpers        Functions that the loop of a kernel calls, written with LLVM's builder
machine_code        From a module of LLVM to machine code for this processor, and machine code as a function to
                    call
pose_driver         The loop around the step of inverse kinematics: W starts at once, each in a lane of its own that
                    is refilled
pose_kernel         The search for one solution of a pose, by a kernel compiled for an arm when first used: the row
                    "kernel"
pose_source         Generates the step of an arm's inverse kinematics as straight-line code, and its kernel, the step
                    in its loop
result_form         How results of a batch lie in memory, and which entries of a matrix are computed and stored at all
scalar_code         Straight-line code as text of LLVM's language, for one state: the same operations as in the vector
                    kernels
single_state        One state at a time: functions that Python calls as it calls C, in a fifth of a microsecond
straight_line       Straight-line code: a symbolic function as a list of additions, products and quotients, each
                    computed once
symbolic_functions  The functions of a batch on symbols: the lean recursion traced as CasADi expressions
transposes          W x W transposes in registers, between rows of states and lanes of a block
"""
