"""Arms with elastic joints: a spring and a damper between the motor side and the link side of every gear."""
