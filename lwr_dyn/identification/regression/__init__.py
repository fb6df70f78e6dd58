"""Linear regression on the torques of an arm.

torque_columns    torques as columns times parameters: bodies, rotors, friction
joint_columns     rotor and friction of one joint as columns
samples           instants of logs: states from positions alone, torques as measured
normal_equations  sums over a log, joint by joint
information       weighted least squares with the noise of every joint; what a log leaves open
grouped           the same for columns that are not one arm's alone
instrumental      instrumental variables, for logs without a filter
long_run          noise of slow sums
stribeck          Stribeck speeds by a bounded search
base_parameters   which combinations of parameters a regressor determines
least_squares     weighted and Huber estimates with covariance
"""
