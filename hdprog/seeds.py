"""Seeds that can be recorded; imports nothing, so that the command line can offer its options."""

LARGEST_SEED = 2**63 - 1
"""The largest whole number that a posterior.nc can hold."""
