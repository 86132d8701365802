"""Gaits by the hundred: sweeps over speed and other quantities, and the libraries they fill."""
