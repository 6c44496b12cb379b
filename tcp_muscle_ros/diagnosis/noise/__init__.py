"""How far readings scatter, and which errors of the model are allowed."""
