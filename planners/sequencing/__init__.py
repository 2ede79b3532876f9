"""In which order stops are visited: open and closed tours at least cost, under rules."""
