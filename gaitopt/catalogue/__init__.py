"""Robots that are asked for by name, and the thirteen-link biped that gaitopt makes itself."""
