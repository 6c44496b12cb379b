"""How a muscle is run and where its values stand: operating parameters, ROS parameter files, and rig files."""
