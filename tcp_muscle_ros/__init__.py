"""TCP artificial muscles in ROS 2: simulation, control, recording and diagnosis."""

__version__ = '0.1.0'
