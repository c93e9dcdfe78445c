"""The drive model and the other models on worn, new and measured records. Run off line."""
