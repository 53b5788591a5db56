"""Generators and checks of this source tree; not in the wheel."""
