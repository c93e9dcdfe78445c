"""Published degradation data through the trend and the first crossing that drives go through."""
