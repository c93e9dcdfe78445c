"""What came out, in words and tables."""
ORACLE = "oracle"
def in_words(results, code): return ""
