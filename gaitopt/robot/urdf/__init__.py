"""URDF files: checked, and cut down to what Pinocchio is to read."""
