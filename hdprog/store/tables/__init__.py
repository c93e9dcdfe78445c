"""The tables of the store; importing this package makes all of them known to `Base.metadata`."""

from hdprog.store.tables.base import Base
from hdprog.store.tables.drives import DriveRow, EventRow, LimitRow, TestRow
from hdprog.store.tables.people import (
    AuditRow,
    LoginFailureRow,
    SessionRow,
    SettingRow,
    TokenRow,
    UserRow,
)
from hdprog.store.tables.results import AnalysisRow, EffectRow, FitRow, ForecastRow
from hdprog.store.tables.work import JobRow

__all__ = [
    "AnalysisRow",
    "AuditRow",
    "Base",
    "DriveRow",
    "EffectRow",
    "EventRow",
    "FitRow",
    "ForecastRow",
    "JobRow",
    "LimitRow",
    "LoginFailureRow",
    "SessionRow",
    "SettingRow",
    "TestRow",
    "TokenRow",
    "UserRow",
]
