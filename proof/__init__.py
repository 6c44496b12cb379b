"""The proof: recordings made by physics of its own, labels sealed, a diagnosis scored against them.

What makes recordings and labels imports nothing from the package under test, and what scores neither: they hand over
rosbag2 bags and take back report.json. Only tool.py, the alternatives and prove.py know the package.
"""
