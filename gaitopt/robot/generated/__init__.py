"""Bipeds that gaitopt makes itself, from a table of parameters."""
