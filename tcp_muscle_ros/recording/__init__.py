"""Recordings in and out: rosbag2 bags, a lab's CSV, protocols, and what is wrong with a recording. No model, no ROS."""
