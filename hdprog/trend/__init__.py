"""Wear over service time: one state behind all tests of a drive."""
