"""References for the joints: a path, a law and an inverse kinematics put together, or plain joint moves."""
