"""Joint chains far too short to be trusted, for what does not hang on how long they run."""

from __future__ import annotations

from hdprog.trend.joint_refit import Effort

HASTY = Effort(8, 8, 0.0, 0.0)
