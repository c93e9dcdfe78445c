"""hdprog's forecasts of one degrading figure against other packages, on simulated fleets."""
