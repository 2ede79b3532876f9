"""Accessibility of a panel: which fasteners a die reaches, which not, why, and what would help."""
