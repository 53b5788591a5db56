"""Rows of the interface table as a chassis serves them: a simulated one, or one behind another door."""
