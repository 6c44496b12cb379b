"""What was imposed and seen, as the model is stepped through it. Knows nothing of what is fitted."""
