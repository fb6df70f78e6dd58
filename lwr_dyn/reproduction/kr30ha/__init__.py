"""The KR 30 HA report recomputed: points, matrices, equations of motion, program."""
