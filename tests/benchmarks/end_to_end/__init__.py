"""Calibration of forecasts end to end: drives drawn from the priors, their loops fitted."""
