"""Which examples there are, with the command line of each."""

from __future__ import annotations

from dataclasses import dataclass

_CYCLOIDAL = (
    "hdprog explain DATA/cycloidal-torque-ramps/base_init1.csv.gz "
    "--columns torque=TORQUE:Nm,angle=POSITION:rev,time=TIME:s --select test_nr=100,101,102"
)
_SPRING = (
    "hdprog explain DATA/torsion-spring/kt-8-1-67-5-09032023-143236.csv.gz "
    "--columns torque=torque_out:Nm,angle=displacement:deg,time=time:s"
)


@dataclass(frozen=True)
class Example:
    """One report of the folder.

    Attributes
    ----------
    name : of its file, without the ending
    title : in the index
    look_at : what it is there to show
    command : what made it; DATA is the folder of measured records
    converges : whether it does; one that shows the opposite has to fail
    tells : words of the sentence of its verdict that the index gives; the first without any
    source : of a measured record, with its licence; its numbers are not handed on
    """

    name: str
    title: str
    look_at: str
    command: str
    source: str = ""
    converges: bool = True
    tells: str = ""


EXAMPLES = (
    Example(
        "wearing-drive",
        "A drive that wears out",
        "Ten tests over 900 h and three limits: by when to inspect, what waiting costs, the fan "
        "of each figure and the hours at which it meets its limit.",
        "hdprog run datasets/wearing-csf-25-80",
    ),
    Example(
        "healthy-drive",
        "A healthy drive",
        "The same drive with little wear: how far off its limits are, and when to test next.",
        "hdprog run datasets/healthy-csf-25-80",
    ),
    Example(
        "undeclared-effect",
        "An effect that nobody declared",
        "Something acts in every test that the drive model lacks: what it is, the error before "
        "and after, and what it had done to the figures.",
        "hdprog run datasets/undeclared-effect/one-effect",
        tells="the error goes",
    ),
    Example(
        "unexplained",
        "An effect that is on no list",
        "One loop with a shape that no known mechanism gives: it is drawn and left open.",
        "hdprog explain datasets/undeclared-effect/on-no-list/loops/t01.csv "
        "--drive datasets/undeclared-effect/on-no-list/drive.toml",
        tells="none of the known effects",
    ),
    Example(
        "not-converged",
        "A fit that did not converge",
        "Two cycles of 11 readings in a quick run: where the loop bends is not told, and the draws "
        "do not settle. The report says so first and marks every number that rests on it.",
        "hdprog fit few-readings.csv --quick",
        converges=False,
    ),
    Example(
        "measured-cycloidal-reducer",
        "A measured cycloidal reducer",
        "Not a strain wave gear, of plastic, with play and stick-slip: a real record with much "
        "that the drive model lacks.",
        _CYCLOIDAL,
        "Record: github.com/JelmerV/Anti-Backlash-Cycloidal-Actuator, CC "
        "BY-SA 4.0; so is this report.",
    ),
    Example(
        "measured-torsion-spring",
        "A measured torsion spring",
        "The spring of a series elastic actuator against a torque sensor, with holds that tell "
        "creep from friction.",
        _SPRING,
        "Record: github.com/ITregear/SeriesElasticActuation-FYP, whose readme lets it be used "
        "freely.",
    ),
)
