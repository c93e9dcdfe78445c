"""The queue of analyses: durable, in the store's own database, one job of a drive at a time.

The queue is that of DBOS Transact, which keeps it in SQLite or PostgreSQL, enqueues in the
transaction of the caller, and hands a dead worker's work to the next.
"""

from __future__ import annotations

import json
import logging
import uuid
from typing import Any

from dbos import DBOS, DBOSClient, DBOSConfig
from dbos import Serializer as DbosSerializer
from sqlalchemy import make_url
from sqlalchemy.orm import Session

from hdprog.store.tables import JobRow

NAME = "analyses"
WORKFLOW = "analyse"
VERSION = "1"  # of what a job's entry in the queue means, not of the program
_POLL_SECONDS = 0.25


class JsonSerializer(DbosSerializer):
    """Entries of the queue as JSON, so that nothing of the database is ever unpickled."""

    def serialize(self, data: Any) -> str:
        """Write an entry; an error that a worker met goes in by its words."""
        return json.dumps(data, default=str)

    def deserialize(self, serialized_data: str) -> Any:
        """Read an entry."""
        return json.loads(serialized_data)

    def name(self) -> str:
        """Name the form."""
        return "json"


class Queue:
    """The queue, as those see it who put work in.

    Parameters
    ----------
    url : address of the store's database
    """

    def __init__(self, url: str) -> None:
        self._url = url
        self._client = DBOSClient(
            system_database_url=url,
            serializer=JsonSerializer(),
            lazy=True,
            application_name="hdprog",
        )

    def prepare(self) -> None:
        """Make or bring up to date the queue's tables."""
        DBOS.migrate(self._url)
        self._client.register_queue(
            NAME,
            worker_concurrency=1,
            partition_concurrency=1,
            polling_interval_sec=_POLL_SECONDS,
            application_name="hdprog",
        )

    def enqueue(self, session: Session, job: JobRow) -> None:
        """Put a job in, in the transaction that made it: both are kept, or neither."""
        self._client.enqueue_in_transaction(
            session,
            {
                "workflow_name": WORKFLOW,
                "queue_name": NAME,
                "workflow_id": str(uuid.uuid4()),
                "app_version": VERSION,
                "queue_partition_key": str(job.drive_id),
                "application_name": "hdprog",
            },
            job.id,
        )

    def holders(self) -> set[str]:
        """Name the workers, living or not, that have taken jobs."""
        taken = self._client.list_workflows(status="PENDING", load_input=False, load_output=False)
        return {one.executor_id for one in taken if one.executor_id is not None}

    def release(self, worker: str) -> int:
        """Put back what a worker that is gone had taken; gives the number of jobs."""
        left = self._client.list_workflows(
            status="PENDING", executor_id=worker, load_input=False, load_output=False
        )
        for one in left:
            self._client.resume_workflow(one.workflow_id, queue_name=NAME)
        return len(left)

    def close(self) -> None:
        """Close the connections."""
        self._client.destroy()


def configuration(url: str, worker: str) -> DBOSConfig:
    """Settings of DBOS for a worker: nothing but the store's database is talked to."""
    return {
        "name": "hdprog",
        "system_database_url": url,
        "executor_id": worker,
        "application_version": VERSION,
        "serializer": JsonSerializer(),
        "run_migrations": False,
        "enable_otlp": False,
        "log_level": "WARNING",
        "console_log_level": "WARNING",
        **({"sys_db_pool_size": 5} if make_url(url).get_backend_name() != "sqlite" else {}),
    }


def quiet_logs() -> None:
    """Keep what the queue says of its own inner life out of the terminal."""
    logging.getLogger("dbos").setLevel(logging.WARNING)
