"""The paper's table and figures from its own numbers, each with its claim and what came out."""
