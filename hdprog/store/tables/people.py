"""Tables of who may do what, and of who did: users, tokens, sessions, the audit trail."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from sqlalchemy import ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column, relationship

from hdprog.store.tables.base import Base, Digest, Name, Word, now


class UserRow(Base):
    """An account; the password is kept as its Argon2 hash only."""

    __tablename__ = "users"

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[Name] = mapped_column(unique=True)
    password_hash: Mapped[str] = mapped_column(String(300))
    role: Mapped[Word]
    disabled: Mapped[bool] = mapped_column(default=False)
    created_at: Mapped[datetime] = mapped_column(default=now)


class TokenRow(Base):
    """A token of the API; only its SHA-256 is kept, which suffices for 256 random bits."""

    __tablename__ = "tokens"

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[Name]
    digest: Mapped[Digest] = mapped_column(unique=True)
    role: Mapped[Word]
    created_at: Mapped[datetime] = mapped_column(default=now)
    used_at: Mapped[datetime | None]
    revoked_at: Mapped[datetime | None]


class SessionRow(Base):
    """A browser that is logged in; `digest` is the SHA-256 of its cookie."""

    __tablename__ = "sessions"

    digest: Mapped[Digest] = mapped_column(primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    created_at: Mapped[datetime] = mapped_column(default=now)
    seen_at: Mapped[datetime] = mapped_column(default=now)

    user: Mapped[UserRow] = relationship(lazy="joined")


class LoginFailureRow(Base):
    """A password that was wrong, by the account or the address it came from."""

    __tablename__ = "login_failures"
    __table_args__ = (Index("ix_login_failures_subject", "subject", "at"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    subject: Mapped[str] = mapped_column(String(200))
    at: Mapped[datetime] = mapped_column(default=now)


class AuditRow(Base):
    """Who changed what, when and from where. Rows are added, never changed."""

    __tablename__ = "audit"
    __table_args__ = (Index("ix_audit_at", "at"),)

    id: Mapped[int] = mapped_column(primary_key=True)
    at: Mapped[datetime] = mapped_column(default=now)
    actor: Mapped[Name]
    address: Mapped[str | None] = mapped_column(String(60))
    action: Mapped[Word]
    subject: Mapped[str] = mapped_column(String(250))
    details: Mapped[dict[str, Any]]


class SettingRow(Base):
    """A setting of the whole service."""

    __tablename__ = "settings"

    name: Mapped[Name] = mapped_column(primary_key=True)
    value: Mapped[dict[str, Any]]
