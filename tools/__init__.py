"""Programs that make parts of this source tree; none of them is in the wheel."""
