"""MJCF files: made whole, checked, and cut down to what Pinocchio is to read."""
