"""When a limit will be crossed, and how good such statements were."""
