"""The proof: recordings made by physics of its own, labels sealed, a diagnosis scored against them.

Nothing here imports the package under test. What it hands over are rosbag2 bags, what it takes back is report.json.
"""
