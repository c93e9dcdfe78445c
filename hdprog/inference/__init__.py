"""Posterior of one loop: priors, likelihood, sampling and its diagnostics."""
