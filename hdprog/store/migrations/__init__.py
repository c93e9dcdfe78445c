"""Steps that bring a database from one version of the store's tables to the next, and back."""
