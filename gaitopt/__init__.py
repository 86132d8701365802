"""gaitopt."""
