"""Closing the loop: what the drive model lacks on a measured record."""
