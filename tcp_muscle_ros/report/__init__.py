"""Findings as tables, figures, files: the same findings, however they were found."""
