"""How far ahead a forecast looked."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Go one step up."""
    with op.batch_alter_table("forecasts", schema=None) as batch_op:
        batch_op.add_column(sa.Column("horizon_hours", sa.Double(), nullable=True))


def downgrade() -> None:
    """Go one step down."""
    with op.batch_alter_table("forecasts", schema=None) as batch_op:
        batch_op.drop_column("horizon_hours")
