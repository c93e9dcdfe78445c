"""Looking things up by the names in addresses."""

from __future__ import annotations

from sqlalchemy.orm import Session

from hdprog.store.drives import find_drive
from hdprog.store.jobs import find_job
from hdprog.store.tables import DriveRow, JobRow, TestRow
from hdprog.store.uploads import find_test, hold_drive_of


class UnknownError(Exception):
    """There is nothing of that name.

    Parameters
    ----------
    words : what there is not, where, and what to do
    """


def drive_named(
    session: Session, name: str, *, with_result: bool = False, alone: bool = False
) -> DriveRow:
    """Find a drive.

    Parameters
    ----------
    session : for looking up, or of a change
    name : the drive's id
    with_result : it must have been analysed
    alone : others who change the drive wait until this change is done

    Raises
    ------
    UnknownError
        where there is none
    """
    drive = find_drive(session, name, alone=alone)
    if drive is None:
        raise UnknownError(
            f"drive: found no drive {name!r}; expected one that is in the fleet. Look it up there, "
            "or make it first."
        )
    if with_result and drive.analysis_id is None:
        raise UnknownError(
            f"drive: found no result for {name!r} yet; expected at least one test that has been "
            "analysed. Upload a test, or wait for its job."
        )
    return drive


def test_named(session: Session, name: str) -> TestRow:
    """Find a test by its name in the store.

    Raises
    ------
    UnknownError
        where there is none
    """
    test = find_test(session, name)
    if test is None:
        raise UnknownError(
            f"test: found no test {name!r}; expected one of a drive's page. Look it up there."
        )
    return test


def test_to_change(session: Session, name: str) -> TestRow:
    """Find a test; others who change its drive wait until this change is done.

    Raises
    ------
    UnknownError
        where there is none
    """
    hold_drive_of(session, name)
    return test_named(session, name)


def job_numbered(session: Session, number: str, *, alone: bool = False) -> JobRow:
    """Find a job.

    Parameters
    ----------
    session : for looking up, or of a change
    number : the job's
    alone : others who change the job wait until this change is done

    Raises
    ------
    UnknownError
        where there is none
    """
    job = find_job(session, number, alone=alone)
    if job is None:
        raise UnknownError(
            f"job: found no job {number}; expected one that an upload gave. Look at the drive's "
            "page."
        )
    return job
