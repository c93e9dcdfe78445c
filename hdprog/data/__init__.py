"""Records of torque against torsion angle: reading, refusing, judging."""
