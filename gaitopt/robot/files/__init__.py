"""A robot's description as files: read, located, and what their formats hide."""
