"""What a process asks of its machine: threads of linear algebra, output that may go away."""
