"""Joint chains far too few and short to be trusted, for what does not hang on them."""

from __future__ import annotations

from hdprog.trend.joint_refit import Effort

HASTY = Effort(8, 8, 0.0, 0.0, chains=8, parts=1)
