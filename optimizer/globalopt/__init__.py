"""The proven optimum: branch and bound over boxes of designs with cutting points."""
