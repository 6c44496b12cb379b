"""How a muscle is run and where its values stand: operating parameters, and ROS parameter files."""
