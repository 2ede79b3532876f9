"""Accessibility of rivets for a simplified tool among boxes: GAA (areas) and GAV (volumes), Dakdouk 2016."""
