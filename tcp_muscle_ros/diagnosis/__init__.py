"""Calibrate, locate, name, select, improve, abstain, propose. Knows recordings and the muscle; no ROS, files, HTML."""
