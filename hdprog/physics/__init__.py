"""Physics of a strain wave gear under output torque with its input locked."""
