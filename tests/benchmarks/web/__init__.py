"""How quick the upload page is: while fits run, under uploads, with a fleet of thousands.

``python -m tests.benchmarks.web.run`` writes results/summary.json and results/summary.md.
"""
