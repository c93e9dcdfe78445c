"""One picture a file; each gives a `Picture` from results."""
