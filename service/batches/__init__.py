"""Batches: many programs for a night, and the report in the morning."""
