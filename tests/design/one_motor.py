"""A table of motors of one kind, with the same gear at all joints."""

from gaitopt.actuators.motors import motors_of

ONE_MOTOR = motors_of(
    """
[motors.one]
torque_constant = 0.1
resistance = 0.1
inertia = 1e-4
peak_current = 60.0
continuous_current = 20.0
voltage = 48.0
no_load_speed = 460.0
mass = 0.6

[[drives]]
joints = "*"
motor = "one"
ratio = 10
efficiency = 0.9
friction = 0.5
"""
)
