"""Who is asking, and what answers carry to keep others out."""
