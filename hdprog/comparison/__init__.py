"""The drive model and the other models on one record, judged by the same numbers."""
