"""What a loop consists of, and the names that its columns go by."""

from __future__ import annotations

from dataclasses import dataclass

from hdprog.units import Dimension

__all__ = ["ROLES", "Role"]


@dataclass(frozen=True)
class Role:
    """Something that a loop consists of, and the names that its column goes by."""

    dimension: Dimension
    names: frozenset[str]
    required: bool = False


ROLES = {
    "torque": Role(
        "torque",
        frozenset(("torque", "output_torque", "load_torque", "moment", "drehmoment")),
        required=True,
    ),
    "angle": Role(
        "angle",
        frozenset(
            (
                "angle",
                "torsion_angle",
                "torsional_angle",
                "torsion",
                "twist",
                "twist_angle",
                "angle_of_twist",
                "torsionswinkel",
                "verdrehwinkel",
                "winkel",
            )
        ),
        required=True,
    ),
    "time": Role(
        "time",
        frozenset(
            (
                "time",
                "elapsed_time",
                "timestamp",
                "time_stamp",
                "datetime",
                "date_time",
                "zeit",
                "uhrzeit",
                "zeitstempel",
                "datum_uhrzeit",
            )
        ),
    ),
    "temperature": Role("temperature", frozenset(("temperature", "temp", "temperatur"))),
    "output_angle": Role("angle", frozenset(("output_angle", "output_position", "abtriebswinkel"))),
}
