"""M functions of the process events, for machines whose builder has given no others."""

from types import MappingProxyType

from robots.processes import StepCode

EVENT_CALLS = MappingProxyType({str(code): f"M{101 + i}" for i, code in enumerate(StepCode)})
"""Line by event code: M101 clamp, M102 drill, and on in the order of `StepCode`."""
