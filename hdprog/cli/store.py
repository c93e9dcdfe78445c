"""`hdprog store`: drives in and out of the upload service's store, and back-ups of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from hdprog.cli.common import nearest_folder
from hdprog.cli.web_extra import Data, DatabaseUrl, data_folder, needs_web, store_folder
from hdprog.errors import UsageError

store = typer.Typer(no_args_is_help=True, help="The upload service's store: in, out, back-up.")
Archive = Annotated[Path, typer.Argument(metavar="ARCHIVE", help="The back-up, a .tar.gz.")]


@store.command("import")
@needs_web
def import_drives(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DRIVE_DIR...", help="Folders with drive.toml.")
    ],
    data: Data = None,
    database: DatabaseUrl = None,
) -> None:
    """Take drive folders into the store and have them analysed.

    Where one of them cannot be used, none is taken in.
    """
    from hdprog.service.importing import take_in_folders
    from hdprog.service.queue import Queue
    from hdprog.store.store import open_store

    with open_store(data_folder(data), database) as opened:
        queue = Queue(opened.database.url)
        queue.prepare()
        for name, count in take_in_folders(opened, queue, folders):
            typer.echo(f"Drive {name}: {count} tests")
        queue.close()


@store.command("export")
@needs_web
def export(
    name: Annotated[str, typer.Argument(metavar="DRIVE", help="The drive's id.")],
    out: Annotated[Path, typer.Option("--out", help="Folder to make.")],
    data: Data = None,
    database: DatabaseUrl = None,
) -> None:
    """Write a drive as the folder that `hdprog run` takes."""
    from hdprog.store.drives import find_drive
    from hdprog.store.folder import export_drive
    from hdprog.store.store import open_store

    if out.exists():
        raise UsageError(f"--out: found something at {out}, expected a name that is free.")
    nearest_folder(out)
    with open_store(store_folder(data), database) as opened, opened.reading() as session:
        drive = find_drive(session, name)
        if drive is None:
            raise UsageError(f"DRIVE: found no drive {name!r}, expected one of the fleet's page.")
        count = export_drive(session, opened.files, drive, out)
    typer.echo(f"Drive folder: {out} ({count} tests)")


@store.command("backup")
@needs_web
def backup(archive: Archive, data: Data = None, database: DatabaseUrl = None) -> None:
    """Copy database and files into one archive; the service may run on."""
    from hdprog.store.backup import back_up
    from hdprog.store.store import open_store

    nearest_folder(archive.absolute().parent, "ARCHIVE", "Give another name.")
    with open_store(store_folder(data), database) as opened:
        size = back_up(opened, archive)
    typer.echo(f"Backup: {archive} ({size / 1e6:.1f} MB)")


@store.command("restore")
@needs_web
def restore(archive: Archive, data: Data = None, database: DatabaseUrl = None) -> None:
    """Put a back-up into an empty data folder."""
    from hdprog.store.backup import restore as put_back
    from hdprog.store.store import open_store

    folder = data_folder(data)
    put_back(archive, folder, database)
    with open_store(folder, database):
        typer.echo(f"Restored into {folder}")
