"""Topics, parameters, services, life and death of a process."""
