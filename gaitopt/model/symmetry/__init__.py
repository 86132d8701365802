"""The symmetry of left and right: found, verified, and restored where it is slightly off."""
