"""Motions of gaits in the forms that engines, controllers and learners read."""
