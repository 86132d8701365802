"""Soles and shapes of the legs: where they touch the ground and each other."""
