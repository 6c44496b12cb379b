"""What a controller achieves: simulated loops and recorded sessions, judged by the same numbers."""
