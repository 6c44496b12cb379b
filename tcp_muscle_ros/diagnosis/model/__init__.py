"""What a diagnosis asks of the machine that it diagnoses, and what the muscle answers."""
