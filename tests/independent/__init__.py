"""Hysteresis loops with known truth, made by a second implementation of the physics."""
