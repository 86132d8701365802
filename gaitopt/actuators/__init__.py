"""Motors and gears: what they can deliver, what they lose, and the inertia they add."""
