"""Pages on paper."""

from __future__ import annotations

import json

from hdprog.store.drives import find_drive
from tests.reporting.drives import wearing
from tests.web.conftest import ClientOf, service_in
from tests.web.test_forecast_dates import analysed


def test_pictures_do_not_wait_to_be_scrolled_to(person: ClientOf) -> None:
    """A browser prints none that it has not loaded."""
    client = person("engineer")
    service = service_in(client)
    name = analysed(service, wearing())
    with service.store.reading() as session:
        drive = find_drive(session, name)
        assert drive is not None
        assert drive.analysis_id is not None
        folder = service.store.files.analysis(drive.analysis_id) / "pictures"
    folder.mkdir(parents=True)
    words = {"alt": "A fan.", "action": "Test again.", "width": 40, "height": 20}
    (folder / "pictures.json").write_text(json.dumps([words]), "utf-8")
    page = client.get(f"/drives/{name}").text
    [picture] = (line for line in page.splitlines() if 'alt="A fan."' in line)
    assert "lazy" not in picture
