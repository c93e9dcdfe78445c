"""What is kept: drives, tests, results and people, in a database beside a folder of files."""
