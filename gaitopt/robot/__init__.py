"""What the machine is: its specification, its URDF, and the model made from a URDF."""
