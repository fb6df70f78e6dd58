"""References for the joints: a path, a profile and an inverse kinematics put together, or plain joint moves."""
