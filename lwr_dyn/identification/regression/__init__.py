"""Linear regression on the torques of an arm.

torque_columns  torques as columns times parameters: bodies, rotors, friction
samples         instants of logs: states from positions alone, torques as measured
least_squares   weighted and Huber estimates with covariance; base parameters; normal equations by their eigenvectors
information     normal equations summed over a log, weighted with the noise of every joint or group of equations
instrumental    instrumental variables, for logs without a filter; noise of slow sums
stribeck        Stribeck speeds by a bounded search, and how well they are known
"""
