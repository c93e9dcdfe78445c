"""Sampling far too short to be trusted, for tests of what does not hang on it."""

from __future__ import annotations

from dataclasses import replace

from hdprog.inference.sampling_plan import QUICK
from hdprog.trend.joint_refit import Effort

SHORT = replace(
    QUICK, warm_up_steps=(10, 10, 10), first_steps=10, most_steps=40, further_steps=0, refits=0
)
"""Of a loop's posterior; it converges nowhere."""
HASTY = Effort(8, 8, 0.0, 0.0, chains=8, parts=1)
"""Of all loops and the trend together."""
