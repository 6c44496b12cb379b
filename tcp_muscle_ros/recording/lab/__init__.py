"""Lab files as they come: read as rows of cells, and understood without a map."""
