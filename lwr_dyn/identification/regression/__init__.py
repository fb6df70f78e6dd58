"""Linear regression on the torques of an arm.

torque_columns    torques as columns times parameters: bodies, rotors, friction
joint_columns     rotor and friction of one joint as columns
samples           instants of logs: states from positions alone, torques as measured
sample_notes      split recordings and lowered cut-offs, in words
normal_equations  sums over a log, joint by joint
grouped           least squares of equations in groups, each with its own noise
spectrum          normal equations by their eigenvectors: inverse, rank, what they leave open
information       weighted least squares with the noise of every joint; what a log leaves open
instrumental      instrumental variables, for logs without a filter
long_run          noise of slow sums
stribeck          Stribeck speeds by a bounded search
base_parameters   which combinations of parameters a regressor determines
least_squares     weighted and Huber estimates with covariance
"""
