"""MJCF files: compiled by MuJoCo, kept as plain numbers, made a Pinocchio model."""
