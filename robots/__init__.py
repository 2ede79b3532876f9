"""Machines, panels, cells and NC programs; stands on `planners`, knows nothing of HTTP."""
