"""Rivet patterns: sizes, spacing, rows, patches, designations and places (Dakdouk 2016, appendix A)."""
