"""How a foot can stand, and the schedule of a step: its phases and its symmetry."""
