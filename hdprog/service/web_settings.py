"""How the server was started; it travels to the server's process in the environment."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

VARIABLE = "HDPROG_SERVE"


@dataclass(frozen=True)
class WebSettings:
    """How the server was started.

    Attributes
    ----------
    data : folder of the store
    url : address of the store's database, None for the one in the folder
    login : pages need one
    max_upload_mb : most that a request may bring
    readers : records that are read at the same time
    hosts : names that requests may ask for; empty for any
    """

    data: Path
    url: str | None = None
    login: bool = True
    max_upload_mb: float = 64.0
    readers: int = 1
    hosts: tuple[str, ...] = ()

    @property
    def max_bytes(self) -> int:
        """Most bytes that a request may bring."""
        return int(self.max_upload_mb * 1_000_000)

    def to_environment(self) -> None:
        """Leave them where the server's process finds them."""
        os.environ[VARIABLE] = json.dumps({**asdict(self), "data": str(self.data)})

    @staticmethod
    def from_environment() -> WebSettings:
        """Find them where the command left them."""
        content = json.loads(os.environ[VARIABLE])
        return WebSettings(
            **{**content, "data": Path(content["data"]), "hosts": tuple(content["hosts"])}
        )
