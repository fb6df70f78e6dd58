"""Linear regression on the torques of an arm.

base_parameters  which combinations of parameters a regressor determines
least_squares    weighted and Huber estimates with covariance
"""
