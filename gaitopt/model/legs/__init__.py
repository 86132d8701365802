"""The two legs in a robot: found, named, measured and limited."""
