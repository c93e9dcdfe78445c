"""What the upload service does behind its pages: reading records, queueing work, running it."""
