"""Forward and inverse kinematics, Jacobians, arm angle."""
