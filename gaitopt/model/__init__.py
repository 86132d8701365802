"""A biped found in a description: legs, soles, symmetry, limits, and its kinematic chain."""
