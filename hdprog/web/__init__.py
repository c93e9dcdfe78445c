"""The upload page: pages for people, and JSON under /api/v1/ for programs."""
