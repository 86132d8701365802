"""Many gaits: sweeps over speed and design, and what they teach."""
