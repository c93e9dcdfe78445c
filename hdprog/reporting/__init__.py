"""The report and the summary of a drive: words, pictures and tables from a `DriveResult`.

Nothing is computed here that a decision hangs on: it is rounded, said in words and drawn.
"""
