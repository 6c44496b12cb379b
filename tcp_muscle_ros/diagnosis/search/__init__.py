"""Which effects: candidates, rivals, what unseen data say, and what remains when none is left."""
