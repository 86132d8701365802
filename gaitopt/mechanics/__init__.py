"""What the machine does: kinematics, inverse dynamics, impact, and an independent referee."""
